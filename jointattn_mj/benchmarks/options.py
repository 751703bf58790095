"""Options of the benchmark. What measures is imported when it is asked for."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from jointattn_mj.options import Checked, Real, Whole


@dataclass(frozen=True)
class BenchmarkOptions(Checked):
    """What is measured, and for how long."""

    what: Literal["scene", "steps", "contingency", "vector", "commands", "all"] = "scene"
    """What to measure. scene: a session from images, rendering alone, a session from the state, cartpole. steps: steps
    of chapter 5 from images, rendering these alone, and steps at the symbolic table. contingency: the detector beside
    recomputation in numpy, whole runs at the table, compiling, transfer entropy beside pyinform. vector: sixteen worlds
    of follow in one process, beside Gymnasium's SyncVectorEnv. commands: help, whole sessions as commands, their
    memory, a frame of a video, and the first run of a new installation. all: each of these in a process of its own."""
    blocks: Annotated[int, Whole("[1, 100000]")] = 8
    """Number of repetitions of each measurement; medians and quartiles are reported."""
    seconds: Annotated[float, Real("[1, 1e6]")] = 30.0
    """Simulated seconds in a block of a session."""
    out: Path | None = None
    """Also write the figures to this JSON file."""

    OLD_CHOICES: ClassVar = {"what": {"turns": "steps"}}
