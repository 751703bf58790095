"""Every command of README and docs could be typed as it stands, and links lead somewhere.

``test_commands_in_order`` runs them.
"""

import contextlib
import io
import re
import runpy
import subprocess
import sys
import tomllib

import pytest
from documented import ROOT, Block, blocks, commands, pages

from jointattn_mj.cli import execution as cli
from jointattn_mj.errors import ConfigError

pytestmark = pytest.mark.integration

OPTION = re.compile(r"^--[a-z][\w.-]*")
FREE = ("apt-get", "rerun", "dask")
"""Programs of other people: only the syntax of these lines is checked."""


def check(words: list[str]) -> None:
    """Fail for a command that could not be typed as it stands."""
    match words:
        case ["jointattn", *arguments]:
            if "--help" not in arguments:
                cli._command_of(arguments)
        case ["make", *targets]:
            known = re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(), re.M)
            assert set(targets) <= set(known)
        case ["python", "-m", module, *arguments]:
            said = help_of(module)
            for option in filter(None, map(OPTION.match, arguments)):
                assert re.search(re.escape(option.group()) + r"\b", said), f"{module} has no {option.group()}"
        case ["pip", "install", *what]:
            extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
            asked = [name for word in what for part in re.findall(r"\[([\w,]+)\]", word) for name in part.split(",")]
            assert set(asked) <= set(extras)
        case ["pytest", *arguments]:
            assert all((ROOT / word).exists() for word in arguments if word.startswith("tests"))
        case [program, *_]:
            assert program in FREE, f"{program}: no test knows how to check it"


def help_of(module: str) -> str:
    """What a module says when it is run with --help."""
    said = io.StringIO()
    arguments, sys.argv = sys.argv, [module, "--help"]
    try:
        with contextlib.redirect_stdout(said), pytest.raises(SystemExit) as stop:
            runpy.run_module(module, run_name="__main__")
    finally:
        sys.argv = arguments
    assert not stop.value.code
    return said.getvalue()


@pytest.mark.parametrize("page", pages(), ids=lambda page: str(page.relative_to(ROOT)))
def test_commands(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    for block in blocks(page):
        assert block.language in ("", "bash", "python"), f"{block.location}: no test runs {block.language}"
        if block.language != "python":
            assert subprocess.run(["bash", "-n"], input=block.text, text=True, capture_output=True).stderr == ""
            for command in commands(block):
                check([*command.words])


def test_what_could_not_be_typed_is_found():
    for bad in (
        "jointattn session --out x --no-such-flag",
        "jointattn develop --preset nonsense --out x",
        "jointattn dance",
        "make coffee",
        "pip install -e '.[nonsense]'",
        "pytest tests/test_nothing.py",
        "cook dinner",
    ):
        (command,) = commands(Block(ROOT / "README.md", 1, "", bad))
        with pytest.raises((AssertionError, SystemExit, ConfigError)):
            check([*command.words])


def test_links_between_files_lead_somewhere():
    """Of the pages outside docs; mkdocs checks those of docs."""
    outside = [page for page in pages() if page.parent.name != "docs"]
    for page in [*outside, ROOT / "CHANGELOG.md"]:
        for target in re.findall(r"\]\(([^)#]+)", page.read_text("utf-8")):
            if not target.startswith("http"):
                assert (page.parent / target).exists(), f"{page.relative_to(ROOT)}: {target}"
