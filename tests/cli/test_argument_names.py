"""Messages of the package name arguments as Python does; on a command line they are options."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import jointattn_mj
from jointattn_mj.cli.argument_names import with_options
from jointattn_mj.cli.commands import COMMANDS
from jointattn_mj.cli.develop import command_for
from jointattn_mj.cli.old_names import typed_names
from jointattn_mj.cli.parsing import module_of
from jointattn_mj.cli.session import in_world

PACKAGE = Path(jointattn_mj.__file__).parent
OF_PROGRAMS = ("apt-get install", "ffmpeg ", "dask worker")
ALIASES = ("--object",)  # of options, beside their definition


@pytest.mark.parametrize(
    ("message", "typed"),
    [
        ("run without `resume` to begin", "run without --resume to begin"),
        ("say `skip_rows=2`", "say --skip-rows 2"),
        ("`missing='break'`, or `yes=True`", "--missing break, or --yes"),
        ("with `overlay=False`", "with --no-overlay"),
        ("start `dask worker tcp://x --nthreads 1`", "start `dask worker tcp://x --nthreads 1`"),
    ],
)
def test_typed(message, typed):
    assert with_options(message) == typed


def test_every_message_outside_the_command_line():
    """It names no option with dashes, and no argument that no command has."""
    options = {
        option for name in COMMANDS if name != "develop" for option in typed_names(getattr(module_of(name), name))
    }
    for world in ("table", "rendered", "realtime"):
        options |= typed_names(command_for([world], None)[0])
    for world in ("video", "camera"):
        options |= typed_names(in_world([f"--world={world}"])[0])
    named = set()
    for path in PACKAGE.rglob("*.py"):
        if path.parent.name != "cli":
            for text in messages(ast.parse(path.read_text())):
                known = text in ALIASES or any(part in text for part in OF_PROGRAMS)
                assert known or not re.search(r"(?<![\w-])--[a-z]", text), (
                    path,
                    text,
                )
                named |= {match[1] for match in re.finditer(r"`([a-z_.]+)(=|`)", text)}
    assert {"resume", "skip_rows"} <= named
    assert {f"--{name.replace('_', '-')}" for name in named} <= options


def messages(tree: ast.AST) -> Iterator[str]:
    """Text in the code that is no docstring, put together where values stand between."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            node.value.value = None
        elif isinstance(node, ast.JoinedStr):
            parts = [part for part in node.values if isinstance(part, ast.Constant)]
            yield "{}".join(str(part.value) for part in parts)
            for part in parts:
                part.value = None
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value
