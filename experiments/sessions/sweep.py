"""Sessions of chapter 6 under every condition that the text compares (section 6.4.3, Fig. 6.8).

    python -m experiments.sessions.sweep --out out/sessions --only truth --runs 20
    python -m experiments.sessions.sweep --out out/sessions --only pixels --runs 5

Each cell is a session folder of its own, ``<out>/<setting>/<seed>``. Running again computes what is missing and goes on
where a killed cell left its checkpoint.
"""

import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import tyro
from joblib import Parallel, delayed

from jointattn_mj.runner import RunOptions, run_session
from jointattn_mj.session import SessionConfig


def setting(
    perception: str, cues: bool, gaze: dict[str, Any] | None = None, learner: dict[str, Any] | None = None
) -> SessionConfig:
    """A session's config that differs from the default in these."""
    config = SessionConfig(perception=perception)
    robot = replace(
        config.robot,
        attention=replace(config.robot.attention, motion_cues=cues),
        gaze=replace(config.robot.gaze, **(gaze or {})),
        learner=replace(config.robot.learner, **(learner or {})),
    )
    return replace(config, robot=robot)


SETTINGS: dict[str, SessionConfig] = {
    "truth/cues": setting("truth", True),
    "truth/no_cues": setting("truth", False),
    "pixels/cues": setting("pixels", True),
    "pixels/no_cues": setting("pixels", False),
    "truth/cues_feedback_alone": setting("truth", True, gaze={"gate": "shut"}),
    "truth/no_cues_feedback_alone": setting("truth", False, gaze={"gate": "shut"}),
    "truth/cues_linear": setting("truth", True, learner={"code": "linear", "rate": 0.1}),
    "truth/cues_hidden_layer": setting("truth", True, learner={"code": "network"}),
    "truth/no_cues_without_context": setting("truth", False, learner={"context": 0.0}),
    "truth/cues_open_loop": setting("truth", True, gaze={"feedback_frames": ()}),
    "truth/cues_face_to_object_only": setting("truth", True, learner={"directions": "face_to_object"}),
}
"""Under string ids: perception, a slash, and what the robot has or lacks."""


@dataclass(frozen=True)
class Options:
    """What to run."""

    out: Path
    """Folder of all cells."""
    only: str = ""
    """Settings whose id begins with this."""
    runs: int = 20
    """Seeds a setting."""
    first: int = 0
    """The first of them."""
    jobs: int = 1
    """Processes."""


def run_cell(out: Path, name: str, seed: int) -> None:
    """One session in its own folder; nothing to do if it is there."""
    os.environ.setdefault("LP_NUM_THREADS", "0")
    folder = out / name / str(seed)
    if (folder / "summary.json").exists():
        return
    config = replace(SETTINGS[name], seed=seed)
    summary = run_session(config, RunOptions(out=folder, resume=(folder / "checkpoint.bin").exists()))
    print(f"{name} {seed}: {summary['gaze_shifts']} shifts, {summary['successes']} successes", flush=True)


def main() -> None:
    """Run the cells."""
    options = tyro.cli(Options, description=__doc__)
    names = [name for name in SETTINGS if name.startswith(options.only)]
    Parallel(n_jobs=options.jobs)(
        delayed(run_cell)(options.out, name, options.first + run) for name in names for run in range(options.runs)
    )


if __name__ == "__main__":
    main()
