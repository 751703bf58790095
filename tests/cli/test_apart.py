"""Commands in processes of their own: what they import, how they end, and that none stays behind."""

import os
import shlex

import pytest

from jointattn_mj.cli import apart, benchmark, costs
from jointattn_mj.cli.main import main
from jointattn_mj.errors import CommandError

pytestmark = pytest.mark.integration

KILLED = "import os; os.kill(os.getpid(), 9)"


def test_modules_of_the_working_directory_are_not_imported(monkeypatch, tmp_path):
    (tmp_path / "enum.py").write_text("raise ImportError('not this')")
    monkeypatch.chdir(tmp_path)
    assert costs.measured("--version").seconds > 0


def test_words_are_those_of_a_shell(tmp_path):
    with pytest.raises(CommandError, match="no command 'two words'"):
        costs.measured(shlex.quote("two words"))


def test_a_folder_for_temporary_files_may_have_spaces(monkeypatch, tmp_path):
    measured = []

    def measure(words, environment=None):
        measured.append(shlex.split(words))
        return costs.Cost(1.0, 1.0)

    monkeypatch.setattr(costs, "measured", measure)
    monkeypatch.setattr(costs.tempfile, "tempdir", str(tmp_path / "a b"))
    (tmp_path / "a b").mkdir()
    costs.run_commands_benchmark(1)
    outs = [words[words.index("--out") + 1] for words in measured if "--out" in words]
    assert len(outs) > 5
    assert all(out.startswith(str(tmp_path / "a b")) for out in outs)


def test_an_interruption_ends_the_command(monkeypatch):
    monkeypatch.setattr(apart, "CODE", "import time; time.sleep(60)")
    monkeypatch.setattr(apart, "ENDS_ALONE_S", 0.1)
    with pytest.raises(KeyboardInterrupt), apart.started(["x"]) as process:
        assert process.poll() is None
        raise KeyboardInterrupt
    assert process.returncode == -15


def test_so_it_does_while_what_a_command_takes_is_measured(monkeypatch):
    started = []

    def interrupted(pid, options):
        started.append(pid)
        raise KeyboardInterrupt

    monkeypatch.setattr(apart, "CODE", "import time; time.sleep(60)")
    monkeypatch.setattr(apart, "ENDS_ALONE_S", 0.1)
    monkeypatch.setattr(costs.os, "wait4", interrupted)
    with pytest.raises(KeyboardInterrupt):
        costs.measured("session")
    with pytest.raises(ProcessLookupError):
        os.kill(started[0], 0)


def test_a_command_that_does_not_stop_is_killed_before_what_started_it(monkeypatch):
    """Compiled code heeds no signal for seconds."""
    assert apart.ENDS_ALONE_S + costs.PATIENCE_S < apart.PATIENCE_S
    deaf = "import signal, sys, time; signal.signal(15, signal.SIG_IGN); print('deaf', file=sys.stderr, flush=True)"
    monkeypatch.setattr(apart, "CODE", f"{deaf}; time.sleep(60)")
    monkeypatch.setattr(apart, "ENDS_ALONE_S", 0.1)
    read, write = os.pipe()
    with (
        open(write, "wb") as errors,
        pytest.raises(KeyboardInterrupt),
        apart.started(["x"], errors=errors, patience_s=0.1) as process,
    ):
        assert os.read(read, 4) == b"deaf"
        raise KeyboardInterrupt
    os.close(read)
    assert process.wait(10) == -9


def test_a_process_that_is_killed_is_told_of(monkeypatch, capfd):
    monkeypatch.setattr(apart, "CODE", KILLED)
    with pytest.raises(CommandError, match=r"^jointattn session: ended by signal 9 \(Killed\)$"):
        costs.measured("session")
    with pytest.raises(SystemExit) as stop:
        main(["benchmark", "--what", "all"])
    assert stop.value.code == 1
    said = capfd.readouterr().err.splitlines()
    assert len(said) == 1
    assert "benchmark --what scene" in said[0]
    assert "ended by signal 9 (Killed)" in said[0]


def test_where_figures_go_is_known_before_any_is_measured(monkeypatch, tmp_path, capfd):
    monkeypatch.setattr(benchmark, "PARTS", dict.fromkeys(benchmark.PARTS, lambda options: pytest.fail("measured")))
    for out, why in ((tmp_path, "is a folder"), ("/proc/x/figures.json", "cannot make the folder")):
        with pytest.raises(SystemExit) as stop:
            main(["benchmark", "--out", str(out)])
        assert stop.value.code == 2
        assert why in capfd.readouterr().err


def test_the_folder_of_the_figures_is_made(monkeypatch, tmp_path):
    monkeypatch.setattr(benchmark, "PARTS", {})
    main(["benchmark", "--what", "all", "--out", str(tmp_path / "out" / "figures.json")])
    assert (tmp_path / "out" / "figures.json").exists()
