"""Command lines for tests (see ``tools.shell``), and how they end."""

import subprocess
import sys
import time
from pathlib import Path

from tools.shell import Outcome, Shell

__all__ = ["Outcome", "Shell", "refused", "stopped"]


def refused(outcome: Outcome, code: int, *words: str) -> None:
    """One message on one line, no traceback, and it says what matters."""
    assert outcome.code == code, outcome.err
    assert outcome.out == ""
    assert outcome.err.count("\n") == 1, outcome.err
    assert outcome.err.startswith("jointattn: ")
    assert "Traceback" not in outcome.err
    for word in words:
        assert word in outcome.err


def stopped(number: int, out: Path, *arguments: object) -> Outcome:
    """How a run into the folder ``out`` ends that gets a signal soon after its config is written."""
    with subprocess.Popen(
        [sys.executable, "-m", "jointattn_mj.cli.main", *map(str, arguments), "--out", str(out)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        while not (out / "config.yaml").exists():
            assert process.poll() is None
            time.sleep(0.02)
        time.sleep(0.2)
        process.send_signal(number)
        said, err = process.communicate(timeout=120)
    return Outcome(process.returncode, said, err)
