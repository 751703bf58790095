"""How fast one command runs many sessions on all cores: ``python -m tools.many_sessions --out many_sessions.json``.

The command is ``jointattn experiment run 6.8``, whose trials are whole sessions of 26 minutes. Each number of processes
runs it anew; a first session of each kind, which compiles, is not counted. With ``--claim drawing --backend gpu
--settings warp/changes`` a graphics card draws for all of them.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from datetime import date
from pathlib import Path
from typing import Any

from jointattn_mj.io.files import write_whole

CODE = "import sys; from jointattn_mj.cli.main import main; sys.exit(main())"
MINUTES = 26
"""Simulated minutes of a session of the claim."""


def measured(
    way: str, setting: str, jobs: int, sessions: int, patience_s: float, kept: Path | None = None
) -> dict[str, Any]:
    """Seconds of the command by the clock, from its start to its end, and what follows from them.

    Args:
        way: Words of the command: claim, backend.
        setting: Of the claim: perception and what the robot has.
        jobs: Processes.
        sessions: Their number, all processes together.
        patience_s: Seconds after which the command is stopped.
        kept: Folder for the trials; None throws them away.
    """
    row: dict[str, Any] = {"setting": setting, "jobs": jobs, "sessions": sessions}
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        words = (
            f"experiment run {way} --setting {setting} --runs {sessions} --jobs {jobs} --out {kept or folder}".split()
        )
        start = time.perf_counter()
        try:
            subprocess.run([sys.executable, "-c", CODE, *words], check=True, timeout=patience_s)
        except subprocess.TimeoutExpired:
            return {**row, "given_up_after_s": patience_s}
        seconds = time.perf_counter() - start
    pace = 60 * MINUTES * sessions / seconds
    return {**row, "seconds": seconds, "times_real_time": pace, "minutes_for_1000_sessions": 1000 * MINUTES / pace}


def main() -> None:
    """Measure, and write and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, help="JSON file for the figures")
    parser.add_argument("--jobs", type=int, nargs="+", default=(1, 2, os.cpu_count() or 1), help="processes")
    parser.add_argument("--settings", nargs="+", default=("state/cues", "pixels/cues"), help="settings of the claim")
    parser.add_argument("--each", type=int, nargs="+", default=(3, 1), help="sessions a process, for each setting")
    parser.add_argument("--claim", default="6.8", help="the claim whose trials are run")
    parser.add_argument("--backend", default="loky", help="where trials run")
    parser.add_argument("--compiled", action="store_true", help="leave out the first session, which compiles")
    parser.add_argument("--kept", type=Path, help="folder for the trials, which may hold none of them")
    parser.add_argument("--patience", type=float, default=600, help="seconds after which a call is given up")
    options = parser.parse_args()
    figures: dict[str, Any] = {"date": date.today().isoformat(), "cores": os.cpu_count(), "runs": []}
    way = f"{options.claim} --backend {options.backend}"
    for setting, each in zip(options.settings, options.each, strict=True):
        if not options.compiled:
            measured(way, setting, 1, 1, options.patience)
        for jobs in options.jobs:
            row = measured(way, setting, jobs, jobs * each, options.patience, options.kept)
            figures["runs"].append(row)
            print(json.dumps(row), flush=True)
            write_whole(options.out, lambda temporary: temporary.write_text(json.dumps(figures, indent=1) + "\n"))


if __name__ == "__main__":
    main()
