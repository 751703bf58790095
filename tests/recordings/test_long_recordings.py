"""How long the largest recordings take, and how much memory: ``pytest -s -m slow`` prints it."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from codings import dyad, looks
from pyarrow import parquet

TIERS = ("mother gaze", "infant gaze", "mother hand", "infant hand", "mother voice", "infant voice")
WORDS = pa.array(["away", "face", "toy", "door"])
MEASURED = """
import json, resource, sys, time
from jointattn_mj.cli.main import main
begun = time.monotonic()
try:
    code = main(sys.argv[1:])
except SystemExit as ended:
    code = ended.code
used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
cpu = sum(usage.ru_utime + usage.ru_stime for usage in used)
peak = next(int(line.split()[1]) for line in open("/proc/self/status") if line.startswith("VmHWM")) / 1e6
print(json.dumps({"code": code, "wall_s": time.monotonic() - begun, "cpu_s": cpu, "peak_gb": peak}), file=sys.stderr)
"""


def measured(*words: object) -> dict[str, float]:
    """Time and memory of a command in a process of its own; code that has to be compiled is so before."""
    done = subprocess.run(
        [sys.executable, "-c", MEASURED, *map(str, words)], capture_output=True, text=True, env=os.environ, check=True
    )
    found: dict[str, float] = json.loads(done.stderr.strip().splitlines()[-1])
    print(done.stdout, found)
    assert not found["code"]
    return found


@pytest.mark.slow
def test_ten_million_steps_of_six_tiers(tmp_path: Path) -> None:
    """All that ``measure`` does, with its 1,000 surrogates and 500 resamples, in 60 s and 2 GB."""
    rng, path = np.random.default_rng(0), tmp_path / "steps.parquet"
    columns = {}
    for name in TIERS:
        codes = np.concatenate([looks(100_000, rng, 1, places=4) for _ in range(100)]).astype(np.int32)
        if name == "infant gaze":
            follows = np.repeat(rng.random(len(codes) // 50) < 0.3, 50)
            codes = np.where(follows, np.roll(columns["mother gaze"].indices.to_numpy(), 8), codes)
        columns[name] = pa.DictionaryArray.from_arrays(pa.array(codes), WORDS)
    parquet.write_table(pa.table(columns), path)
    columns.clear()
    words = ("measure", path, "--source", TIERS[0], "--target", TIERS[1], "--condition", TIERS[3])
    measured(*words, "--surrogates", 2, "--resamples", 2)
    found = measured(*words)
    assert found["cpu_s"] < 60  # of two cores; the time itself depends on what else runs
    assert found["peak_gb"] < 2
    each = [measured("measure", path, "--source", tier, "--target", TIERS[1]) for tier in TIERS if tier != TIERS[1]]
    assert sum(command["cpu_s"] for command in each) < 60
    assert max(command["peak_gb"] for command in each) < 2


@pytest.mark.slow
def test_forty_dyads_and_thirty_lags(tmp_path: Path) -> None:
    """40 dyads of 10 minutes at 10 Hz, each on its own and all together, at 30 lags."""
    path = tmp_path / "dyads.csv"
    lines = ["dyad,mother,infant"]
    for i in range(40):
        own, partner = (np.resize(side, 6000) for side in dyad(np.random.default_rng(i), 1))
        lines += [f"d{i},{a},{b}" for a, b in zip(own, partner, strict=True)]
    path.write_text("\n".join(lines) + "\n")
    words = ("measure", path, "--source", "mother", "--target", "infant", "--recording", "dyad", "--scan", 30)
    measured(*words, "--surrogates", 2, "--resamples", 2)
    assert measured(*words)["cpu_s"] < 60
