"""A lock has one holder at a time, and none once its process has ended, however that was."""

import errno
import fcntl
import os
import signal
import subprocess
import sys

import pytest

from jointattn_mj.io.lock import locked

HOLDER = """
import sys, time
from pathlib import Path
from jointattn_mj.io.lock import locked
with locked(Path(sys.argv[1])) as held:
    print(held, flush=True)
    time.sleep(600)
"""


def test_one_at_a_time(tmp_path):
    path = tmp_path / "lock"
    with locked(path) as first:
        with locked(path) as second:
            assert (first, second) == (True, False)
        assert path.exists()  # whoever did not get it deletes nothing
        with locked(tmp_path / "another") as other:
            assert other
    assert not list(tmp_path.iterdir())
    with locked(path) as again:
        assert again


def test_given_up_after_an_error(tmp_path):
    with pytest.raises(KeyboardInterrupt), locked(tmp_path / "lock"):
        raise KeyboardInterrupt
    assert not list(tmp_path.iterdir())


def test_given_up_by_a_killed_process(tmp_path):
    path = tmp_path / "lock"
    with subprocess.Popen([sys.executable, "-c", HOLDER, str(path)], stdout=subprocess.PIPE, text=True) as holder:
        assert holder.stdout.readline() == "True\n"
        with locked(path) as held:
            assert not held
        holder.send_signal(signal.SIGKILL)
    assert path.exists()
    with locked(path) as held:
        assert held
    assert not list(tmp_path.iterdir())


def test_deleted_while_somebody_waits_for_it(tmp_path, monkeypatch):
    """Its last holder deletes it between another's opening and locking: a lock on a file that nobody finds is none."""
    path, lock = tmp_path / "lock", fcntl.flock

    def late(file, how):
        monkeypatch.undo()
        path.unlink()
        lock(file, how)

    monkeypatch.setattr(fcntl, "flock", late)
    with locked(path) as held:
        assert held
        with locked(path) as second:
            assert not second


def test_no_locks_and_no_folder(tmp_path, monkeypatch):
    with pytest.raises(FileNotFoundError), locked(tmp_path / "nowhere" / "lock"):
        pass

    def unknown(file, how):
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(fcntl, "flock", unknown)
    with pytest.raises(OSError, match="No locks"), locked(tmp_path / "lock"):
        pass
