"""Fixations of the attention model in a video, fixations.parquet: one row a fixation."""

from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from jointattn_mj.footage.frame_map import FrameMap
from jointattn_mj.footage.reader import RATE
from jointattn_mj.footage.watcher import Watcher
from jointattn_mj.gaze_following.columns import described

MEANINGS = {
    "start_s": "time in the video at which the fixation began",
    "end_s": "time at which attention shifted, or the video ended",
    "candidate": "candidate that was fixated",
    "x_px": "its mean location while visible, pixels of the robot's image",
    "y_px": "its mean location while visible, pixels of the robot's image",
    "video_x_px": "the same in pixels of the video",
    "video_y_px": "the same in pixels of the video",
    "visible": "share of the frames in which it was detected",
    "moving": "share of the frames in which it was detected to move",
}


@dataclass
class Fixation:
    """One fixation; times are frames of 1/30 s."""

    candidate: int
    start: int
    end: int  # exclusive
    px_sum: np.ndarray  # (2,) sum of its pixels in the robot's image, over frames in which it was visible
    video_px_sum: np.ndarray  # (2,) the same in the video's image
    frames_visible: int = 0
    frames_moving: int = 0

    @property
    def seconds(self) -> float:
        """Duration of the fixation."""
        return (self.end - self.start) / RATE


class Fixations:
    """Collects the fixations of a watcher, frame by frame.

    Attributes:
        all: Fixations so far.
    """

    def __init__(self) -> None:
        self.all: list[Fixation] = []
        self._open = False

    def note(self, watcher: Watcher, frame: int, mapped: FrameMap) -> None:
        """Add a frame.

        Args:
            watcher: Has perceived the frame.
            frame: Its number, from 0.
            mapped: From pixels of the video to those of the robot's image.
        """
        attended, percept = watcher.attended, watcher.percept
        if attended is None or percept is None or watcher.goal is not None:
            self._open = False
            return
        if not self._open or self.all[-1].candidate != attended:
            self.all.append(Fixation(attended, frame, frame, np.zeros(2), np.zeros(2)))
            self._open = True
        fixation = self.all[-1]
        fixation.end = frame + 1
        fixation.frames_moving += bool(percept.moves[attended])
        if percept.visible[attended]:
            fixation.frames_visible += 1
            fixation.px_sum += percept.px[attended]
            fixation.video_px_sum += mapped.to_video(percept.px[attended])

    def table(self, names: tuple[str, ...], start_s: float = 0.0) -> pa.Table:
        """Table of all fixations.

        Args:
            names: Of the candidates.
            start_s: Time of the first frame, s.
        """
        schema = pa.schema(
            [(name, pa.string() if name == "candidate" else pa.float64()) for name in MEANINGS],
        )
        return described(
            pa.Table.from_pylist([_row(fixation, names, start_s) for fixation in self.all], schema=schema), MEANINGS
        )

    def shares(self, names: tuple[str, ...]) -> dict[str, dict[str, float]]:
        """Number of fixations, and their time in seconds, by candidate."""
        chosen = {name: [fixation for fixation in self.all if names[fixation.candidate] == name] for name in names}
        return {
            name: {"fixations": len(fixations), "seconds": round(sum(fixation.seconds for fixation in fixations), 3)}
            for name, fixations in chosen.items()
        }


def _row(fixation: Fixation, names: tuple[str, ...], start_s: float) -> dict[str, float | str | None]:
    frames = fixation.end - fixation.start
    px, video_px = (
        [float(value) for value in total / fixation.frames_visible] if fixation.frames_visible else [None, None]
        for total in (fixation.px_sum, fixation.video_px_sum)
    )
    values = (
        start_s + fixation.start / RATE, start_s + fixation.end / RATE, names[fixation.candidate], *px, *video_px,
        fixation.frames_visible / frames, fixation.frames_moving / frames,
    )  # fmt: skip
    return dict(zip(MEANINGS, values, strict=True))
