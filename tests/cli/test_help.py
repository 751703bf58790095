"""What the command line says of itself: the overview, and help in two lengths."""

import os
import re
import subprocess
import sys

import pytest
from shell import Shell

from jointattn_mj import __version__
from jointattn_mj.cli.commands import COMMANDS, overview
from jointattn_mj.cli.help import ADVANCED
from jointattn_mj.cli.old_names import typed_names
from jointattn_mj.cli.parsing import module_of

pytestmark = pytest.mark.integration

SCREENS, LINES, COLUMNS = 2, 45, 100
OPTION = re.compile(r"^ +(?:-h, )?(--[\w.-]+)", re.M)
UNNAMED = ("--file", "--first", "--second", "--video", "--objects")
"""Typed without a name; the last stands beside another form."""
PARTS = {"session": ("--robot.", "--pixels.", "--world."), "perceive": ("--attention.", "--pixels.", "--som.")}


@pytest.fixture(scope="module")
def jointattn():
    os.environ["COLUMNS"], before = str(COLUMNS), os.environ.get("COLUMNS")
    shell = Shell()
    yield shell
    shell.close()
    del os.environ["COLUMNS"]
    if before is not None:
        os.environ["COLUMNS"] = before


@pytest.mark.parametrize("arguments", [(), ("--help",), ("-h",)])
def test_the_overview_imports_neither_numpy_nor_tyro(arguments):
    program = (
        "import sys; from jointattn_mj.cli.main import main; "
        f"main({list(arguments)}); print(*(name for name in ('numpy', 'tyro') if name in sys.modules), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (done.returncode, done.stderr.strip()) == (0, "")
    assert done.stdout.strip() == overview()
    for name, command in COMMANDS.items():
        assert re.search(rf"^  {name} +{re.escape(command.does)}$", done.stdout, re.M)


def test_overview_is_narrow():
    assert max(map(len, overview().splitlines())) <= 110


def test_version(jointattn):
    outcome = jointattn("--version")
    assert (outcome.code, outcome.out, outcome.err) == (0, f"jointattn-mj {__version__}\n", "")


@pytest.mark.parametrize("command", [*COMMANDS, "experiment run", "experiment report"])
def test_help_fits_two_screens(jointattn, command):
    outcome = jointattn(*command.split(), "--help")
    assert (outcome.code, outcome.err) == (0, "")
    lines = outcome.out.splitlines()
    assert len(lines) <= SCREENS * LINES
    assert max(map(len, lines)) <= COLUMNS
    assert not [line for line in lines if line != line.rstrip()]


@pytest.mark.parametrize("command", PARTS)
def test_everyday_help_is_part_of_all(jointattn, command):
    everyday, everything = (jointattn(command, option).out for option in ("--help", "--help-all"))
    short, long = (OPTION.findall(text) for text in (everyday, everything))
    assert len(short) == len(set(short))
    assert len(long) == len(set(long))
    assert set(short) < set(long)
    assert not [option for option in short if "." in option]
    for part in PARTS[command]:
        assert [option for option in long if option.startswith(part)]
    assert "--help-all" in everyday and "--config FILE" in everyday


@pytest.mark.parametrize("command", ["measure", "discover", "recordings", "transitions", "agreement", "perceive"])
def test_help_all_has_every_option_once(jointattn, command):
    known = typed_names(getattr(module_of(command), command))
    everyday, everything = (jointattn(command, option).out for option in ("--help", "--help-all"))
    listed = OPTION.findall(everything)
    assert known - {*listed, *UNNAMED} == set()
    assert len(listed) == len(set(listed)) > len(OPTION.findall(everyday))
    assert "--help-all" in everyday and ADVANCED in everything


def test_help_has_no_marks_of_docstrings(jointattn):
    for words in (("session", "--help-all"), ("view", "--help"), ("develop", "table", "--help-all")):
        said = jointattn(*words).out
        assert "``" not in said and "\n\n\n" not in said


def test_tuned_constants_come_last(jointattn):
    before, _, after = jointattn("session", "--help-all").out.partition(ADVANCED)
    assert "--pixels.faces.haar-min-px" in after
    assert "--pixels.faces.haar-min-px" not in before
    assert "--robot.gaze.gate " in before


def test_help_says_what_values_may_be(jointattn):
    said = jointattn("session", "--help").out
    for words in ("--seed INT[0,9e18]", "--caregiver {robin,noa,", "--minutes FLOAT(0,1e9]", "--no-motion-cues"):
        assert words in said
    said = jointattn("session", "--help-all").out
    for words in ("--robot.som.rate-start FLOAT[1e-9,1]", "{min,max}"):
        assert words in said


@pytest.mark.parametrize(
    ("command", "required"),
    [
        ("measure", ["source", "target"]),
        ("discover", ["sensors", "actions", "results"]),
        ("play", ["agent"]),
        ("experiment run", ["out"]),
    ],
)
def test_what_is_required_comes_first(jointattn, command, required):
    options = OPTION.findall(jointattn(*command.split(), "--help").out)
    assert options[: len(required) + 1] == ["--help", *(f"--{name}" for name in required)]


def test_flags_that_are_on_show_both_forms(jointattn):
    said = jointattn("session", "--help").out
    assert "  --motion-cues, --no-motion-cues\n" in said
    assert "  --resume  " in said and "--no-resume" not in said
    assert "  --table.profile, --table.no-profile\n" in jointattn("develop", "table", "--help-all").out


@pytest.mark.parametrize(("world", "every"), [("table", 2_000_000), ("rendered", 10_000), ("realtime", 500)])
def test_each_world_has_its_own_options(jointattn, world, every):
    said = " ".join(jointattn("develop", world, "--help").out.split())
    assert f"a kill loses no more than these. (default: {every})" in said
    assert ("--video" in said) == (world == "rendered")
    if world != "rendered":
        outcome = jointattn("develop", world, "--video", "--out", "x")
        assert (outcome.code, "no option --video" in outcome.err) == (2, True)


@pytest.mark.parametrize(("words", "old"), [(("--perception", "truth"), True), (("--perception", "moon"), False)])
def test_help_is_given_whatever_else_is_typed(jointattn, words, old):
    """Old names are taken as without it, and a wrong value does not hide what would be right."""
    done = jointattn("session", *words, "--help")
    assert done.code == 0 and "--perception {pixels,state}" in done.out
    assert done.err.count("\n") == old
