"""Simulated hours in one process: memory over time, and bytes written in all."""

import shlex
import time
from dataclasses import dataclass, field
from pathlib import Path

from tools.reliability.subjects import Run

SAMPLE_S = 0.25
WARM, DONE = 0.25, 0.95
"""Memory is compared between these shares of a run: before, everything is loaded, and after, results are made."""
FLAT_MB = 8.0
"""What it may grow by in between; the allocator's own ups and downs are some megabytes."""
POINTS = 24
"""Of memory that are kept."""


@dataclass(frozen=True)
class Day:
    """A long run: its command, and how long it takes in simulated time."""

    name: str
    command: str
    """``{n}`` stands for its length."""
    an_hour: float
    """Length of a simulated hour, in minutes or steps."""
    hours: float = 24.0
    """Of a whole day; less where images are rendered."""


DAYS = (
    Day("session, state", "session --perception state --minutes {n}", 60),
    Day("develop, table", "develop table --preset thesis --steps {n}", 1_000_000),
    Day(
        "develop, realtime, state",
        "develop realtime --realtime.perception state --steps 200000 --minutes {n}",
        60,
    ),
    Day("session, images", "session --minutes {n}", 60, hours=1.0),
    Day("develop, rendered", "develop rendered --steps {n}", 20_000, hours=1.0),
)
"""Steps of the table have no length: a million stand for an hour, and 20,000 where each is an image."""


RESULTS = (".png", ".parquet")
"""The first results are such files."""


@dataclass
class Course:
    """Memory and files of a run's process over time."""

    seconds: list[float] = field(default_factory=list)
    """Since the start."""
    memory: list[float] = field(default_factory=list)
    """Resident, MB."""
    written: int = 0
    """Bytes, to whatever file."""
    results_s: float | None = None
    """When it began to write its results."""

    def at(self, share: float) -> float:
        """Memory at a share of the time before the results, MB: the median of the samples around it."""
        until = self.results_s or self.seconds[-1]
        near = [m for s, m in zip(self.seconds, self.memory, strict=True) if abs(s / until - share) < 0.04]
        return sorted(near)[len(near) // 2] if near else float("nan")


def watch(run: Run, out: Path) -> Course:
    """Sample a process until it ends; ``out`` is its folder."""
    course, began = Course(), time.monotonic()
    folder = Path(f"/proc/{run.process.pid}")
    while run.running():
        try:
            status, io = (folder / "status").read_text(), (folder / "io").read_text()
        except OSError:
            break
        resident = next((line.split()[1] for line in status.splitlines() if line.startswith("VmRSS:")), None)
        if resident is not None:
            course.seconds.append(time.monotonic() - began)
            course.memory.append(int(resident) / 1024)
            if course.results_s is None and any(path.suffix in RESULTS for path in out.glob("*")):
                course.results_s = course.seconds[-1]
            course.written = int(next(line.split()[1] for line in io.splitlines() if line.startswith("wchar:")))
        time.sleep(SAMPLE_S)
    return course


def spend(day: Day, share: float, out: Path) -> dict[str, object]:
    """``share`` of a day; what came of it.

    Args:
        day: A long run of a command.
        share: Of a day, 0 to 1.
        out: Folder for results.
    """
    hours = day.hours * share
    length = hours * day.an_hour
    words = shlex.split(day.command.format(n=f"{length:.0f}"))
    run = Run([*words, "--out", str(out)])
    course = watch(run, out)
    code, said = run.end()
    left = sum(path.stat().st_size for path in out.rglob("*") if path.is_file())
    grown = course.at(DONE) - course.at(WARM)
    row = {
        "run": day.name,
        "simulated hours": round(hours, 2),
        "seconds": round(course.seconds[-1]),
        "MB at a quarter": round(course.at(WARM)),
        "at a half": round(course.at(0.5)),
        "before results": round(course.at(DONE)),
        "highest": round(max(course.memory)),
        "grown, MB": round(grown, 1),
        "MB written": round(course.written / 1e6, 1),
        "MB left": round(left / 1e6, 1),
    }
    trouble = f"ended with {code}: {said[-500:]}" if code else ""
    if not trouble and not grown < FLAT_MB:
        trouble = f"memory grew by {grown:.0f} MB"
    step = max(1, len(course.memory) // POINTS)
    curve = [[round(s), round(m)] for s, m in zip(course.seconds[::step], course.memory[::step], strict=True)]
    return {"row": row, "trouble": trouble, "curve": curve}


def summary(spent: list[dict]) -> dict[str, object]:
    """Rows and troubles of all long runs, for the file of results."""
    return {
        "rows": [run["row"] for run in spent],
        "wrong": [{"run": run["row"]["run"], "trouble": run["trouble"]} for run in spent if run["trouble"]],
        "memory (s, MB)": {run["row"]["run"]: run["curve"] for run in spent},
    }
