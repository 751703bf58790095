"""The harnesses of ``tools.reliability`` tell the truth: what is lost, refused badly or taken in silence is found."""

import random
import signal
import sys
from pathlib import Path

import pytest

from tools.reliability import kills, together
from tools.reliability.folders import contents, differences
from tools.reliability.hours import FLAT_MB, Course
from tools.reliability.inputs import calls, checkpoints, options, tables
from tools.reliability.malformed import Input, numbers, refused, summary, verdict
from tools.reliability.report import BEGIN, END, PAGE, page
from tools.reliability.results import load, save, table
from tools.reliability.subjects import Subject
from tools.shell import HUNG, Outcome, Shell

pytestmark = pytest.mark.integration

TOY = """
import json, os, sys, time
from pathlib import Path

out = Path(sys.argv[sys.argv.index("--out") + 1])
lines, state = [], out / "checkpoint.bin"
if "--resume" in sys.argv:
    if not state.exists():
        print("toy: no checkpoint", file=sys.stderr)
        sys.exit(2)
    lines = json.loads(state.read_text())
elif state.exists() and "careless" not in sys.argv:
    print("toy: already holds a run", file=sys.stderr)
    sys.exit(2)
out.mkdir(parents=True, exist_ok=True)

def write(path, content):
    (out / f".{os.getpid()}").write_text(json.dumps(content))
    os.replace(out / f".{os.getpid()}", path)
    for left in out.glob(".*"):
        left.unlink()

while len(lines) < 40:
    lines.append(len(lines))
    time.sleep(0.005)
    if len(lines) % 5 == 0:
        write(state, lines)
write(out / "lines.json", {"lines": lines, "wall_seconds": time.time()})
"""


@pytest.fixture
def toy(tmp_path):
    script = tmp_path / "toy.py"
    script.write_text(TOY)
    return lambda name: Subject(name, name, program=(sys.executable, str(script)))


def trials(subject: Subject, folder: Path, number: int = 6, by: int = signal.SIGKILL) -> list[kills.KillTrial]:
    peace = kills.reference(subject, folder / "peace", {})
    return [kills.kill_until_done(subject, seed, peace, folder / str(seed), {}, by) for seed in range(number)]


@pytest.fixture
def anywhere(monkeypatch):
    """Toys are done before their first second is over."""
    monkeypatch.setattr(kills, "MOMENTS", ("anywhere",))


def test_a_run_that_loses_nothing(toy, anywhere, tmp_path):
    found = trials(toy("careful"), tmp_path)
    (row,) = kills.summary(found)["rows"]
    assert row["kills"] >= 1 and row["trials"] == 6
    assert not any(trial.lost for trial in found), found


def test_a_run_that_loses_something_is_found_out(toy, anywhere, tmp_path):
    forgetful = toy("forgetful")
    script = Path(forgetful.program[1])
    script.write_text(TOY.replace("json.loads(state.read_text())", "json.loads(state.read_text())[1:]"))
    found = kills.summary(trials(forgetful, tmp_path))
    (row,) = found["rows"]
    assert row["bytes of difference"] > 0 and found["wrong"]


def test_a_run_that_ends_wrongly_when_it_is_stopped_is_found_out(toy, anywhere, tmp_path):
    silent = toy("silent")
    script = Path(silent.program[1])
    script.write_text(f"import signal\nsignal.signal(signal.SIGINT, lambda *_: sys.exit(1))\n{TOY}")
    found = trials(silent, tmp_path, by=signal.SIGINT)
    assert any(trial.trouble.startswith("ended with 1 when it was stopped") for trial in found)


def test_two_in_one_folder(toy, tmp_path):
    careless = toy("careless")
    alone = (kills.reference(careless, tmp_path / "alone", {}),) * 2
    pair = together.start_two(careless, 1, alone, tmp_path / "shared", {})
    assert pair.trouble == "both took the folder"
    assert together.summary([pair])["rows"] == [{"run": "careless", "pairs": 1, "one refused": 0, "wrong": 1}]


def test_folders_are_compared_to_the_byte_but_for_time(tmp_path):
    for name, text, seconds in (("one", "abc", 1), ("other", "abd", 2)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "a.txt").write_text(text)
        (tmp_path / name / "s.json").write_text(f'{{"x": [{{"wall_seconds": {seconds}}}]}}')
        (tmp_path / name / "checkpoint.bin").write_text(name)
    first, second = contents(tmp_path / "one"), contents(tmp_path / "other")
    assert differences(first, second) == {"a.txt": 1}
    (tmp_path / "one" / ".left.12.bin").touch()
    assert differences(contents(tmp_path / "one"), second) == {"a.txt": 1, ".left.12.bin": 1}


@pytest.mark.parametrize(
    ("outcome", "failure"),
    [
        (Outcome(2, "", "jointattn: minutes must be a number; got nan\n"), None),
        (Outcome(HUNG, "", ""), "hang"),
        (Outcome(-11, "", ""), "signal"),
        (Outcome(134, "", "terminate called"), "signal"),
        (Outcome(2, "", "Traceback (most recent call last):\n  x\njointattn: no\n"), "traceback"),
        (Outcome(3, "", "no"), "exit code"),
        (Outcome(0, "fine", ""), "accepted"),
        (Outcome(1, "", ""), "nothing said"),
        (Outcome(2, "", "one\ntwo"), "several lines"),
    ],
)
def test_verdicts(outcome, failure):
    found = verdict(Input("options", "session --minutes = 'nan'", ("x",), result=refused), outcome)
    assert (found and found.failure) == failure


def test_results_that_are_no_numbers():
    assert numbers(Outcome(0, "TE 0.5 [0.1, 0.2]\ninfant, nanny", "")) == ""
    assert numbers(Outcome(0, "TE nan", "")) == "printed nan"
    assert numbers(Outcome(0, "TE [-inf, 1]", "")) == "printed -inf"


@pytest.fixture(scope="module")
def shell(tmp_path_factory):
    shell = Shell(tmp_path_factory.mktemp("here"))
    yield shell
    shell.close()


def test_what_hangs_is_ended_and_what_wants_all_memory_gets_none(shell):
    assert shell.python("while True: pass", seconds=0.5).code == HUNG
    assert "MemoryError" in shell.python("bytearray(1 << 40)", memory=1 << 34).err
    assert shell.python("import os; os.abort()").code == -6


@pytest.fixture(scope="module")
def listed(shell):
    """Options of every command."""
    return {base: options.options_of(shell, base, {}) for base in options.BASES}


def test_options_are_all_that_help_lists(listed):
    for base, found in listed.items():
        assert len(found) > 1, base
    (minutes,) = [option for option in listed[options.BASES[0]] if option.name == "--minutes"]
    assert (minutes.takes, minutes.default) == ("FLOAT(0,1e9]", "26.0")
    words = dict(options.values_for(minutes, random.Random(0)))
    assert words[("nan",)] and words[("",)] and words[("1", "1")]
    assert not dict(options.values_for(options.Option("--x", "INT", "None"), random.Random(0)))[("None",)]
    assert ("inf",) not in dict(options.values_for(options.Option("--x", "FLOAT", "inf"), random.Random(0)))


def test_inputs_are_the_same_for_a_seed(listed, monkeypatch, tmp_path):
    monkeypatch.setattr(options, "options_of", lambda shell, base, locations: listed[base])
    for make in (
        lambda chance: options.inputs(None, chance, 100, tmp_path, {}),
        lambda chance: [*calls.inputs(chance, 50)],
        lambda chance: [*tables.inputs(chance, 40, tmp_path)],
    ):
        first, second = ([given.what for given in make(random.Random(3))] for _ in range(2))
        assert first == second and len(first) >= 40
    commands = {given.arguments[0] for given in options.inputs(None, random.Random(0), 100, tmp_path, {})}
    assert commands == {base.command.split()[0] for base in options.BASES}


def test_failures_of_one_cause_are_counted_together():
    given = [Input("tables", f"number {n}", result=refused) for n in range(3)]
    failures = [verdict(case, Outcome(1, "", f"Traceback (most recent call last):\nValueError: row {n}"))
                for n, case in enumerate(given)]  # fmt: skip
    found = summary(given, failures)
    assert found["rows"][0]["tried"] == found["rows"][0]["traceback"] == 3
    assert [cause["times"] for cause in found["wrong"]] == [3]


def test_a_made_up_checkpoint_is_right_but_for_what_it_holds(tmp_path):
    from dataclasses import replace

    from jointattn_mj.errors import CheckpointError
    from jointattn_mj.gaze_following.session import SessionConfig
    from jointattn_mj.io import checkpoint

    path, config = tmp_path / "c", SessionConfig(minutes=1, perception="state")
    checkpoint.save(path, [1.0, "a"], config)
    made = checkpoints.made_up(path.read_bytes(), random.Random(0))
    if made is None:
        pytest.skip("checkpoints are of a format of which none are made up")
    path.write_bytes(made[1])
    with pytest.raises(CheckpointError, match="another config"):  # and not "damaged"
        checkpoint.load(path, replace(config, seed=7))


def test_memory_that_grows_is_seen():
    course = Course(seconds=[*map(float, range(100))], memory=[100.0 + n for n in range(100)])
    assert course.at(0.95) - course.at(0.25) > FLAT_MB


def test_the_page_says_what_is_stored(tmp_path):
    text = PAGE.read_text("utf-8")
    assert page(text) == text, "run python -m tools.reliability report"
    save("kills", {"rows": [{"run": "session", "kills": 1234}], "wrong": []}, 12.3, tmp_path)
    assert "| session | 1,234 |" in page(f"a {BEGIN} old {END} b", tmp_path)
    assert load("kills", tmp_path)["seconds"] == 12 and load("hours", tmp_path) is None
    assert table([]) == "Nothing."
    with pytest.raises(ValueError, match="found 0"):
        page("no marks")
