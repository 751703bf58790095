"""Every code block of README and docs: Python is run, commands are parsed, and run where that is quick."""

import contextlib
import io
import re
import runpy
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path
from types import ModuleType

import pytest

from jointattn_mj import cli
from jointattn_mj.errors import ConfigError

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "experiments" / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```", re.M | re.S)
OPTION = re.compile(r"^--[a-z][\w.-]*")
FREE = ("apt-get", "rerun", "taskset")
"""Programs of other people: only the syntax of these lines is checked."""
QUICK_MINUTES, QUICK_STEPS, QUICK_PICTURES = 2, 40_000, 500


def blocks(page: Path) -> list[tuple[str, str]]:
    """Language and text of each fenced block."""
    return BLOCK.findall(page.read_text("utf-8"))


def commands(text: str) -> list[list[str]]:
    """The words of every line that is one, without comments, settings of the environment and ``taskset -c 0``."""
    lines = [shlex.split(re.sub(r"(^|\s)#.*", "", line)) for line in text.replace("\\\n", " ").splitlines()]
    found = []
    for words in filter(None, lines):
        while "=" in words[0]:
            words = words[1:]
        found.append(words[3:] if words[0] == "taskset" else words)
    return found


def after(words: list[str], option: str, otherwise: float) -> float:
    """The number that follows an option."""
    return float(words[words.index(option) + 1]) if option in words else otherwise


def quick(words: list[str]) -> bool:
    """Whether a ``jointattn`` command takes seconds, and has what it needs."""
    match words[0]:
        case "measure" | "discover":
            return Path(words[1]).exists()
        case "session":
            return "truth" in words and "--start-from" not in words and after(words, "--minutes", 26) <= QUICK_MINUTES
        case "develop":
            return after(words, "--steps", 100_000) <= (QUICK_PICTURES if "rendered" in words else QUICK_STEPS)
        case "experiment":
            return words[1] == "list" or "my_claims.registry" in words
    return False


def check(words: list[str]) -> None:
    """Fail for a command that could not be typed as it stands."""
    match words:
        case ["jointattn", *arguments]:
            if quick(arguments):
                cli.main(arguments)
            elif "--help" not in arguments:
                cli._parse(arguments)
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
            assert program in FREE, f"{program}: tests/test_docs.py does not know how to check it"


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


@pytest.fixture
def namespace(tmp_path, monkeypatch):
    """An empty folder to work in, and a module of which the page's classes can be, as pickles need."""
    monkeypatch.chdir(tmp_path)
    module = ModuleType("page")
    monkeypatch.setitem(sys.modules, "page", module)
    monkeypatch.setattr(sys, "path", [*sys.path])
    return module.__dict__


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_code_blocks(page, namespace):
    for language, text in blocks(page):
        match language:
            case "python":
                exec(compile(text, f"{page.name}: {text.splitlines()[0]}", "exec"), namespace)
            case "" | "bash":
                assert subprocess.run(["bash", "-n"], input=text, text=True, capture_output=True).stderr == ""
                for words in commands(text):
                    check(words)
            case _:
                pytest.fail(f"no test knows how to check a block of {language}")


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
        (words,) = commands(bad)
        with pytest.raises((AssertionError, SystemExit, ConfigError)):
            check(words)


def test_links_between_files_lead_somewhere():
    """Within README and experiments; mkdocs checks those of docs."""
    for page in PAGES[:2]:
        for target in re.findall(r"\]\(([^)#]+)", page.read_text("utf-8")):
            if not target.startswith("http"):
                assert (page.parent / target).exists(), f"{page.name}: {target}"
