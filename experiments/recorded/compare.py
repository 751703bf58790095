"""Sessions at videos of the rendered caregiver against sessions in the rendered world, seed by seed.

``python -m experiments.recorded.compare --seeds 1000 1001 --out out/recorded`` films the caregiver of each seed, lets
the robot learn at the video and in the world, and leaves ``compared.json``. What is there already is not made again. A
seed takes about half an hour of one core.
"""

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jointattn_mj.footage.sessions.config import VideoSessionConfig
from jointattn_mj.footage.sessions.lens import HeadConfig
from jointattn_mj.footage.sessions.run import run_footage_session
from jointattn_mj.gaze_following.agent import FamiliariseConfig
from jointattn_mj.gaze_following.run import SessionOptions, run_session
from jointattn_mj.gaze_following.session import SessionConfig
from jointattn_mj.io.files import write_whole
from jointattn_mj.sweeps.statistics import mean_interval

from .table_video import FOV_DEG, TILT_DEG, write_video

OBJECTS = ("red", "green", "blue", "yellow")
WORLD, DETECTORS = "world", ("templates", "yunet")
NUMBERS = ("gaze_shifts", "successes", "success_rate", "late_success_rate", "gaze_shifts_by_learner")


@dataclass(frozen=True)
class Compared:
    """Numbers of one session."""

    seed: int
    where: str
    """``world``, or the detector with which the video was watched."""
    numbers: dict[str, float | None]


def video_config(folder: Path, seed: int, detector: Any, minutes: float) -> VideoSessionConfig:
    """The session at the video in a folder.

    Args:
        folder: What ``write_video`` has left.
        seed: Of the robot's random draws.
        detector: What finds faces.
        minutes: Length of the session.
    """
    return VideoSessionConfig(
        video_file=folder / "table.mp4",
        coding=folder / "coding.csv",
        objects=OBJECTS,
        detector=detector,
        seed=seed,
        minutes=minutes,
        head=HeadConfig(fov_deg=FOV_DEG, mount_deg=TILT_DEG),
    )


def sessions_of(seed: int, out: Path, detectors: Sequence[str], minutes: float) -> list[Compared]:
    """The session of a seed in the world, and at its video with each detector; folders that are there are read.

    Args:
        seed: Of world and robot.
        out: Folder for all seeds.
        detectors: What finds faces in the video.
        minutes: Length of the sessions.
    """
    film, compared = out / f"video_{seed}", []
    if not (film / "table.mp4").exists():
        write_video(film, seed, FamiliariseConfig().minutes + minutes)
    for where in (WORLD, *detectors):
        folder = out / f"{where}_{seed}"
        resume = (folder / "checkpoint.bin").exists()
        if where == WORLD:
            summary: Any = run_session(SessionConfig(seed=seed, minutes=minutes), SessionOptions(folder, resume=resume))
        else:
            summary = run_footage_session(video_config(film, seed, where, minutes), folder, resume)
        compared.append(Compared(seed, where, {name: getattr(summary, name) for name in NUMBERS}))
        print(f"seed {seed}, {where}: {compared[-1].numbers}", file=sys.stderr, flush=True)
    return compared


def table(sessions: Sequence[Compared]) -> str:
    """Means with their intervals, one row a number, and the differences of the same seeds."""
    wheres = list(dict.fromkeys(session.where for session in sessions))
    lines = ["".join([f"{'':24}", *(f"{where:>28}" for where in wheres)])]
    for name in NUMBERS:
        values = {
            where: {session.seed: session.numbers[name] for session in sessions if session.where == where}
            for where in wheres
        }
        cells = [str(mean_interval([v for v in values[where].values() if v is not None])) for where in wheres]
        lines.append("".join([f"{name:24}", *(f"{cell:>28}" for cell in cells)]))
        for where in wheres:
            both = [
                (values[where][seed], values[WORLD][seed]) for seed in values[where] if seed in values.get(WORLD, {})
            ]
            apart = [video - world for video, world in both if video is not None and world is not None]
            if where != WORLD and apart:
                lines.append(f"{'  less that in the world':24}  {where}: {mean_interval(apart)}")
    return "\n".join(lines)


def main() -> None:
    """Compare the sessions of some seeds."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seeds", type=int, nargs="+", default=[1000], help="of world and robot")
    parser.add_argument("--detectors", nargs="+", default=list(DETECTORS), choices=DETECTORS, help="what finds faces")
    parser.add_argument("--minutes", type=float, default=SessionConfig.minutes, help="length of the sessions")
    parser.add_argument("--out", type=Path, required=True, help="folder; made when missing")
    given = parser.parse_args()
    compared = [
        session for seed in given.seeds for session in sessions_of(seed, given.out, given.detectors, given.minutes)
    ]
    rows = [vars(session) for session in compared]
    write_whole(given.out / "compared.json", lambda path: path.write_text(json.dumps(rows, indent=1) + "\n"))
    print(table(compared))


if __name__ == "__main__":
    main()
