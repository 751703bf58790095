"""What the attention model looked at, and for how long: one row a fixation."""

from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from jointattn_mj.footage.frame_map import FrameMap
from jointattn_mj.footage.reader import RATE
from jointattn_mj.footage.watcher import Watcher
from jointattn_mj.gaze_following.columns import described

MEANINGS = {
    "start_s": "time at which attention arrived",
    "end_s": "time at which it was drawn elsewhere, or the video ended",
    "candidate": "what was looked at",
    "x_px": "mean place while it was seen, pixels of the robot's image",
    "y_px": "mean place while it was seen, pixels of the robot's image",
    "video_x_px": "the same in pixels of the video",
    "video_y_px": "the same in pixels of the video",
    "seen": "share of the frames in which it was seen",
    "moving": "share of the frames in which it was seen to move",
}


@dataclass
class Fixation:
    """One fixation, in frames of 1/30 s; places are pixels."""

    candidate: int
    start: int
    end: int  # exclusive
    location: np.ndarray  # (2,) sum over the frames in which it was seen, robot's image
    video_location: np.ndarray  # (2,) the same in the video
    visible: int = 0
    moving: int = 0

    @property
    def seconds(self) -> float:
        """How long it lasted."""
        return (self.end - self.start) / RATE


class Fixations:
    """Collects the fixations of a watcher, frame by frame."""

    def __init__(self) -> None:
        self.all: list[Fixation] = []
        self._open = False

    def note(self, watcher: Watcher, frame: int, mapped: FrameMap) -> None:
        """What ``watcher`` did in this frame; ``mapped``: how its image comes from the video's."""
        attended, percept = watcher.attended, watcher.percept
        if attended is None or percept is None or watcher.goal is not None:
            self._open = False
            return
        if not self._open or self.all[-1].candidate != attended:
            self.all.append(Fixation(attended, frame, frame, np.zeros(2), np.zeros(2)))
            self._open = True
        fixation = self.all[-1]
        fixation.end = frame + 1
        fixation.moving += bool(percept.moves[attended])
        if percept.visible[attended]:
            fixation.visible += 1
            fixation.location += percept.px[attended]
            fixation.video_location += mapped.to_video(percept.px[attended])

    def table(self, names: tuple[str, ...]) -> pa.Table:
        """A row a fixation; it has its columns even without a row."""
        schema = pa.schema(
            [(name, pa.string() if name == "candidate" else pa.float64()) for name in MEANINGS],
        )
        return described(pa.Table.from_pylist([_row(one, names) for one in self.all], schema=schema), MEANINGS)

    def shares(self, names: tuple[str, ...]) -> dict[str, dict[str, float]]:
        """Number of fixations, and their time in seconds, by candidate."""
        chosen = {name: [one for one in self.all if names[one.candidate] == name] for name in names}
        return {
            name: {"fixations": len(found), "seconds": round(sum(one.seconds for one in found), 3)}
            for name, found in chosen.items()
        }


def _row(one: Fixation, names: tuple[str, ...]) -> dict[str, float | str | None]:
    frames = one.end - one.start
    location, video = (
        [float(value) for value in total / one.visible] if one.visible else [None, None]
        for total in (one.location, one.video_location)
    )
    values = (
        one.start / RATE, one.end / RATE, names[one.candidate], *location, *video,
        one.visible / frames, one.moving / frames,
    )  # fmt: skip
    return dict(zip(MEANINGS, values, strict=True))
