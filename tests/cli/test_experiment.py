"""``jointattn experiment`` as it is typed: killed, stopped, started twice, it ends in the very same files."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from shell import Outcome, Shell

from experiments.registry import REGISTRY

pytestmark = pytest.mark.integration

HERE = Path(__file__).parents[1]
ROOT = HERE.parent
FILES = ("report.html", "claims.json", "claims.csv", "claims.md", "figures/1.1-heads.png")
TOYS = ("--registry", "toys.registry")
PATH = os.pathsep.join(filter(None, [str(HERE), os.environ.get("PYTHONPATH")]))
ENVIRONMENT = os.environ | {"PYTHONPATH": PATH}


@pytest.fixture(scope="module")
def jointattn():
    os.environ["PYTHONPATH"], before = PATH, os.environ.get("PYTHONPATH")
    shell = Shell()
    yield shell
    shell.close()
    os.environ.pop("PYTHONPATH")
    if before is not None:
        os.environ["PYTHONPATH"] = before


def start(out: Path, *options: str, trouble: str = "") -> subprocess.Popen:
    """A run in a session of its own, as a terminal would start it."""
    arguments = ["experiment", "run", "1.1", *TOYS, "--jobs", "1", "--out", str(out), *options]
    return subprocess.Popen(
        [sys.executable, "-m", "jointattn_mj.cli.main", *arguments],
        env=ENVIRONMENT | {"TOY_TROUBLE": trouble},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def go(jointattn: Shell, out: Path, *options: object, trouble: str = "", **how: int) -> Outcome:
    """A run from beginning to end."""
    arguments = ["experiment", "run", "1.1", *TOYS, "--jobs", 1, "--out", out, *options]
    return jointattn(*arguments, env={"TOY_TROUBLE": trouble}, **how)


def finish(process: subprocess.Popen) -> Outcome:
    out, err = process.communicate(timeout=60)
    return Outcome(process.returncode, out, err)


def stored(out: Path) -> int:
    return len(list((out / "trials" / "1.1").glob("[!.]*.json")))


def wait_for_trials(out: Path, process: subprocess.Popen, count: int = 2) -> None:
    while not ((out / "trials" / "1.1").is_dir() and stored(out) >= count):
        assert process.poll() is None, process.stderr.read()
        time.sleep(0.01)


@pytest.fixture(scope="module")
def undisturbed(jointattn, tmp_path_factory) -> dict[str, bytes]:
    out = tmp_path_factory.mktemp("runs") / "undisturbed"
    outcome = go(jointattn, out)
    assert (outcome.code, outcome.out) == (0, f"{out}\n")
    assert outcome.err.startswith("16 trials to compute, 0 stored already\n16/16 trials, 0 failed")
    return reported(jointattn, out)


def reported(jointattn: Shell, out: Path) -> dict[str, bytes]:
    outcome = jointattn("experiment", "report", out, *TOYS)
    assert (outcome.code, outcome.out, outcome.err) == (0, f"{out / 'report.html'}\n", "")
    return {name: (out / name).read_bytes().replace(str(out).encode(), b"OUT") for name in FILES}


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_stopped_and_started_again(jointattn, undisturbed, tmp_path, number):
    process = start(tmp_path, trouble="sleep:0.05")
    wait_for_trials(tmp_path, process)
    if number in (signal.SIGINT, signal.SIGHUP):
        os.killpg(process.pid, number)  # as a terminal does: the workers get it too
    else:
        process.send_signal(number)
    outcome = finish(process)
    if number == signal.SIGKILL:
        assert outcome.code == -signal.SIGKILL
    else:
        assert outcome.code == 130
        assert f"jointattn: stopped; the same command goes on with what is in {tmp_path}\n" in outcome.err
        assert "Traceback" not in outcome.err
    done = stored(tmp_path)
    assert 2 <= done < 16
    again = go(jointattn, tmp_path)
    assert again.err.startswith(f"{16 - done} trials to compute, {done} stored already\n")
    assert reported(jointattn, tmp_path) == undisturbed


def test_two_at_once(jointattn, undisturbed, tmp_path):
    first, second = start(tmp_path, trouble="sleep:0.05"), start(tmp_path, trouble="sleep:0.05")
    assert (finish(first).code, finish(second).code) == (0, 0)
    assert reported(jointattn, tmp_path) == undisturbed


def test_a_trial_that_fails(jointattn, undisturbed, tmp_path):
    outcome = go(jointattn, tmp_path, trouble="error:3")
    assert (outcome.code, outcome.out) == (1, f"{tmp_path}\n")
    assert (
        "1.1 fair seed 3: ValueError: the coin stands on its edge\n    alone: jointattn experiment run" in outcome.err
    )
    assert "jointattn: 2 trials failed; the same command tries them again\n" in outcome.err
    (alone,) = [line for line in outcome.err.splitlines() if "alone:" in line and "--setting fair" in line]
    assert jointattn(*alone.split()[2:]).code == 0
    assert stored(tmp_path) == 15
    go(jointattn, tmp_path)
    assert reported(jointattn, tmp_path) == undisturbed


def test_a_full_disk(jointattn, undisturbed, tmp_path):
    outcome = go(jointattn, tmp_path, file_limit=50)
    assert outcome.code != 0
    assert stored(tmp_path) == 0
    go(jointattn, tmp_path)
    assert reported(jointattn, tmp_path) == undisturbed


def test_a_damaged_note_of_a_failure(jointattn, tmp_path):
    """It is counted and named, and goes away once its trial has succeeded."""
    go(jointattn, tmp_path, "--runs", 2, trouble="error:1")
    note = next((tmp_path / "failed" / "1.1").glob("*.json"))
    whole = note.read_text()
    for damaged in ("{bad", "[]", "\x00", whole[:40], '{"setting": "fair"}', "[" * 100_000):
        note.write_text(damaged)
        outcome = jointattn("experiment", "list", *TOYS, "--out", tmp_path)
        assert (outcome.code, outcome.err) == (0, "")
        assert "2/16, 2 failed" in outcome.out
        outcome = jointattn("experiment", "report", tmp_path, *TOYS)
        assert (outcome.code, outcome.err) == (0, "")
        assert f"Notes of failures that cannot be read: 1 ({note.name})" in (tmp_path / "report.html").read_text()
    go(jointattn, tmp_path, "--runs", 2)
    assert not note.exists()


def test_folders_in_the_place_of_files(jointattn, tmp_path):
    go(jointattn, tmp_path, "--runs", 2, trouble="error:1")
    trial, note = (next((tmp_path / kind / "1.1").glob("[!.]*.json")) for kind in ("trials", "failed"))
    for path in (trial, note):
        path.unlink()
        path.mkdir()
    outcome = jointattn("experiment", "report", tmp_path, *TOYS)
    assert (outcome.code, outcome.err) == (0, "")
    page = (tmp_path / "report.html").read_text()
    assert f"Files that hold no trial: 1 ({trial.name})" in page
    assert "2 failed" in jointattn("experiment", "list", *TOYS, "--out", tmp_path).out
    outcome = go(jointattn, tmp_path, "--runs", 2)
    assert outcome.code == 2
    assert f"\njointattn: cannot write {trial}: Is a directory" in outcome.err


def test_list(jointattn, tmp_path):
    outcome = jointattn("experiment", "list", *TOYS)
    assert [line.split()[0] for line in outcome.out.splitlines()] == ["id", "1.1", "1.2"]
    go(jointattn, tmp_path, "--runs", 3)
    lines = jointattn("experiment", "list", *TOYS, "--out", tmp_path).out.splitlines()
    assert "6/16" in lines[1]
    assert "0/2" in lines[2]


def test_our_own_claims_are_listed_in_no_time():
    """Nothing of what they need is imported for it."""
    program = (
        "import sys\nfrom jointattn_mj.cli.main import main\nmain(['experiment', 'list'])\n"
        "print(sorted(sys.modules.keys() & {'mujoco', 'torch', 'cv2', 'scipy', 'numba', 'matplotlib'}))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=HERE.parent)
    assert done.stdout.splitlines()[-1] == "[]"
    assert done.stdout.startswith("id")


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["run", "9.9", *TOYS, "--out", "x"], 2, "no claim has the id '9.9'; there are 1.1, 1.2"),
        (["run", *TOYS, "--out", "x"], 2, "expected ids of claims, or all; there are 1.1, 1.2"),
        (["run", "1.1", *TOYS, "--out", "x", "--setting", "bent"], 2, "no setting is called 'bent'"),
        (["run", "1.1", *TOYS, "--out", "x", "--runs", "0"], 2, "runs: expected a whole number in [1, 1e6]"),
        (["run", "1.1", *TOYS, "--out", "x", "--backend", "dask"], 2, "needs --address"),
        (["run", "1.1", *TOYS], 2, "--out"),
        (["run", "1.1", *TOYS, "--out", "/proc/x"], 2, "cannot make the folder"),
        (["report", "nowhere", *TOYS], 2, "nowhere holds no trials"),
        (["list", "--registry", "no.such.thing"], 2, "cannot import no.such.thing; expected a module"),
        (["list", "--registry", "toys.coin.sweep"], 2, "has no REGISTRY"),
        (["list", "--registry", "shell"], 2, "shell has no REGISTRY"),
        (["list", "--registry", "toys.faulty"], 1, "cannot import toys.faulty: ZeroDivisionError: division by zero"),
        (["list", "--registry", "nix"], 2, "cannot import nix; expected a module"),
        (["list", "--registry", ".."], 2, "'..' is no name of a module"),
        (["list", "--registry", ""], 2, "'' is no name of a module"),
        (["list", "--registry", "../x"], 2, "'../x' is no name of a module"),
        (["list", "--registry", "a\nb"], 2, "is no name of a module"),
        (["list", "--registry", "x" * 5000], 2, "is no name of a module"),
        (["list", *TOYS, "--out", "/proc/self/mem"], 2, "is no folder of results that can be read: Not a directory"),
        (["list", *TOYS, "--out", "x" * 5000], 2, "255 bytes"),
        (["report", "/proc/self/mem", *TOYS], 2, "is no folder of results that can be read: Not a directory"),
    ],
)
def test_what_cannot_be_done(jointattn, arguments, code, words):
    outcome = jointattn("experiment", *arguments)
    assert (outcome.code, outcome.out) == (code, "")
    assert outcome.err.startswith("jointattn: ")
    assert outcome.err.count("\n") == 1
    assert words in outcome.err
    assert not Path("x").exists()


def test_experiments_that_the_package_carries(tmp_path):
    """As after installing a wheel: the package elsewhere, with experiments inside."""
    site = tmp_path / "site"
    unwanted = shutil.ignore_patterns("__pycache__", "figures", "*.mp4")
    shutil.copytree(ROOT / "jointattn_mj", site / "jointattn_mj", ignore=unwanted)
    shutil.copytree(ROOT / "experiments", site / "jointattn_mj" / "experiments", ignore=unwanted)
    program = (
        "from jointattn_mj.api.claims import experiments_registry\n"
        "registry = experiments_registry()\n"
        "print(registry['5.2'].trial.__module__, len(registry))\n"
        "print({registry[claim].analyse({}) is None for claim in registry})\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(site)},
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == [f"jointattn_mj.experiments.tables {len(REGISTRY)}", "{False}"]


def test_another_package_of_that_name(tmp_path):
    (tmp_path / "experiments").mkdir()
    (tmp_path / "experiments" / "__init__.py").touch()
    program = "from jointattn_mj.api.claims import experiments_registry\nexperiments_registry()\n"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=tmp_path)
    assert f"expected the package experiments in {ROOT / 'experiments'}; got {tmp_path}" in done.stderr
