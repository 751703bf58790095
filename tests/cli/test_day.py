"""A day of a session and ten million turns at the table take no more memory than an hour and a million turns.

``pytest -m slow tests/test_day.py``; JOINTATTN_DAY_MINUTES and JOINTATTN_DAY_STEPS make a shorter day.
"""

import os
import subprocess
import sys

import pytest

MINUTES = os.environ.get("JOINTATTN_DAY_MINUTES", "1440")
STEPS = os.environ.get("JOINTATTN_DAY_STEPS", "10000000")
MOST_MORE_MB = 64
"""Caches of Parquet's and NumPy's allocators; the log of a day is 622 MB."""


def peak_mb(*arguments: str) -> float:
    """Most memory that a command ever held."""
    process = subprocess.Popen(
        [sys.executable, "-m", "jointattn_mj.cli.main", *arguments],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0
    return usage.ru_maxrss / (1e6 if sys.platform == "darwin" else 1e3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "option", "short", "long"),
    [(("session", "--perception", "state"), "--minutes", "60", MINUTES), (("develop",), "--steps", "1000000", STEPS)],
    ids=["session", "develop"],
)
def test_memory_of_a_day(tmp_path, command, option, short, long):
    peaks = [peak_mb(*command, "--out", str(tmp_path / amount), option, amount) for amount in (short, long)]
    print(f"{command[0]} {option} {short}: {peaks[0]:.0f} MB, {long}: {peaks[1]:.0f} MB")
    assert peaks[1] - peaks[0] < MOST_MORE_MB
