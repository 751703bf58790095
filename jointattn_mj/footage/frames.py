"""What was perceived in one frame of a video, with names for numbers: what Python users iterate over."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from jointattn_mj.footage.people import Sighting
from jointattn_mj.footage.reader import RATE, Still
from jointattn_mj.footage.viewing import Viewing
from jointattn_mj.footage.yunet import BOX
from jointattn_mj.io.table import Table

Flow = dict[str, tuple[float, float]]


@dataclass(frozen=True)
class PerceivedCandidate:
    """An object or the face in one frame; pixels are those of the robot's image of 320x240, x right and y down."""

    detected: bool
    """Whether it was found in the image."""
    x_px: float | None
    """Centre; None where it was not detected."""
    y_px: float | None
    """Centre; None where it was not detected."""
    moves: bool
    """Whether it was seen to move (eq. 6.3)."""
    saliency: float
    """S_i, eq. 6.5 and 6.6."""
    motion: float
    """m_i, eq. 6.3, frames."""
    interest: float
    """I_i, eq. 6.1; attention is drawn by it."""

    def __repr__(self) -> str:
        if self.x_px is None or self.y_px is None:
            return f"PerceivedCandidate(not detected, interest {self.interest:.3g})"
        moves = ", moves" if self.moves else ""
        return f"PerceivedCandidate(at {self.x_px:.1f}, {self.y_px:.1f} px{moves}, interest {self.interest:.3g})"


@dataclass(frozen=True)
class PerceivedPerson:
    """One face in one frame; pixels are those of the video."""

    person: int
    """Number of the person, from 1; 0 while it is not known."""
    sure: bool
    """Whether it is known that it is this person."""
    box_px: tuple[float, float, float, float]
    """x, y, width and height, from brow to chin."""
    score: float
    """Of the detector, 0..1."""
    yaw_deg: float | None
    """Yaw of the head against the line to the camera, positive to the right; None where it cannot be measured."""
    yaw_error_deg: float | None
    """Its expected error."""
    of_interest: bool
    """Whether it is the face that attention knows."""


@dataclass(frozen=True)
class PerceivedFrame:
    """One frame of a video as the robot perceives it: what ``perceive`` gives one after the other.

    Frames are a thirtieth of a second apart. Pixels of face and objects are those of the robot's image.

    Examples:
        >>> from jointattn_mj.footage.frames import PerceivedCandidate, PerceivedFrame
        >>> face = PerceivedCandidate(True, 160.0, 52.5, True, 0.5, 3.0, 1.5)
        >>> cup = PerceivedCandidate(False, None, None, False, 1.0, 0.0, 1.0)
        >>> frame = PerceivedFrame(0.5, 12, True, face, 0.9, {"cup": cup}, "face")
        >>> frame.objects["cup"]
        PerceivedCandidate(not detected, interest 1)
        >>> frame.face.x_px
        160.0
    """

    time_s: float
    """Time in the video, as players count it."""
    image: int
    """Number of the video's image that the frame shows, from 0."""
    fresh: bool
    """Whether that is another image than in the frame before."""
    face: PerceivedCandidate
    """The face."""
    face_fit: float | None
    """Score of the face, 0..1; with the detector templates, its correlation with the best view, -1..1."""
    objects: dict[str, PerceivedCandidate]
    """The objects, by name."""
    fixation: str | None
    """What is fixated: ``"face"`` or the name of an object. None at first, and while attention shifts."""
    people: tuple[PerceivedPerson, ...] = field(default=(), compare=False)
    """All faces, the largest first. Empty for frames that were read from a folder: see ``PerceptionResult.people``."""
    flow: Flow = field(default_factory=dict, compare=False)
    """Mean optical flow of what has texture, by name: pixels right and down since the image that it was compared with.

    Empty for frames that were read from a folder, which holds no flow."""

    def __repr__(self) -> str:
        everything = {"face": self.face, **self.objects}
        detected = ", ".join(
            f"{name}{' moves' * percept.moves}" for name, percept in everything.items() if percept.detected
        )
        return f"PerceivedFrame({self.time_s:.2f} s, detected: {detected or 'nothing'}; fixates {self.fixation})"


def frame_now(viewing: Viewing, still: Still) -> PerceivedFrame:
    """What a viewing has made of the frame that it was shown last.

    Args:
        viewing: Has just been shown ``still``.
        still: The frame.
    """
    watcher = viewing.watcher
    attention, percept, fit = watcher.attention, watcher.percept, watcher.perceiver.fix.score
    if percept is None:
        raise ValueError("expected a viewing that has been shown a frame; got a new one")
    locations = [(single(x), single(y)) for x, y in percept.px]
    candidates = {
        name: PerceivedCandidate(
            detected=bool(percept.visible[k]),
            x_px=locations[k][0],
            y_px=locations[k][1],
            moves=bool(percept.moves[k]),
            saliency=float(np.float32(attention.saliency[k])),
            motion=float(np.float32(attention.motion[k])),
            interest=float(np.float32(attention.interest[k])),
        )
        for k, name in enumerate(viewing.names)
    }
    attended = None if watcher.attended is None or watcher.goal is not None else viewing.names[watcher.attended]
    return PerceivedFrame(
        time_s=viewing.footage.time_of(viewing.frames - 1),
        image=still.number,
        fresh=bool(still.fresh),
        face=candidates.pop("face"),
        face_fit=single(fit),
        objects=candidates,
        fixation=attended,
        people=tuple(_person(face, face is viewing.chosen) for face in viewing.visible_faces),
        flow=_flow(viewing),
    )


def _person(sighting: Sighting, chosen: bool) -> PerceivedPerson:
    x, y, wide, high = (float(value) for value in sighting.face[BOX])
    yaw, error = single(sighting.yaw_deg), single(sighting.yaw_error_deg)
    return PerceivedPerson(sighting.person, sighting.sure, (x, y, wide, high), sighting.score, yaw, error, chosen)


def frames_of(percepts: Table, names: tuple[str, ...]) -> Iterator[PerceivedFrame]:
    """The frames that a table of percepts holds.

    Args:
        percepts: What ``percepts.parquet`` holds.
        names: Of the candidates, the face's last.
    """
    for batch in percepts.arrow.to_batches(max_chunksize=RATE * 60):
        for row in batch.to_pylist():
            candidates = {name: _candidate(row, name) for name in names}
            yield PerceivedFrame(
                time_s=row["time_s"],
                image=row["image"],
                fresh=row["fresh"],
                face=candidates.pop("face"),
                face_fit=row["face_fit"],
                objects=candidates,
                fixation=None if row["head_moves"] else row["attended"],
            )


def _candidate(row: dict[str, Any], name: str) -> PerceivedCandidate:
    columns = ("visible", "x_px", "y_px", "moves", "saliency", "motion", "interest")
    return PerceivedCandidate(*(row[f"{name}_{column}"] for column in columns))


def single(value: float) -> float | None:
    """A number in the precision of the tables; None for NaN."""
    return None if np.isnan(value) else float(np.float32(value))


def _flow(viewing: Viewing) -> Flow:
    motion = viewing.watcher.perceiver.motion
    if motion is None:
        return {}
    blocks = {name: motion.flow[motion.owner == k] for k, name in enumerate(viewing.names)}
    means = {name: flow.mean(axis=0) for name, flow in blocks.items() if len(flow)}
    return {name: (float(x), float(y)) for name, (x, y) in means.items()}
