"""A session before a person in numbers: what ``summary.json`` holds."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from jointattn_mj.footage.sessions.frames import WideFrames
from jointattn_mj.gaze_following.shifts import Shifts
from jointattn_mj.gaze_following.summary import LATE_MINUTES, LEARNER
from jointattn_mj.io.summaries import Summary

NOT_KNOWN = "not known"
"""Success, where nobody has said where the person looks."""


@dataclass(frozen=True, repr=False)
class CameraTimes(Summary):
    """How well this machine kept up with a camera."""

    images: int
    """Images that the camera has given."""
    images_a_second: float | None
    """Their rate."""
    images_lost: int
    """Images that were followed by another before they were taken up, but for those of a pause."""
    frames_lost: int
    """Frames of a thirtieth of a second in which the robot saw no new image because the machine was late."""
    latency_median_ms: float | None
    """Time from the arrival of an image in this machine to the robot's decision. The camera's own delay is added."""
    latency_percentile_95_ms: float | None
    """95 of 100 images took less."""


@dataclass(frozen=True, repr=False)
class FootageSessionSummary(Summary):
    """A session before a person in numbers. Rates are shares of 1, and None where there was nothing to count.

    ``gaze_shifts`` are those from the person's face to an object. Two summaries are equal if all but ``wall_seconds``
    and ``camera`` is.
    """

    minutes: float
    """Minutes of the session, by the clock of the video or camera, without those in which faces were learned."""
    frames: int
    """Frames, 30 a second."""
    images: int
    """Images of video or camera that were different ones."""
    wall_seconds: float = field(compare=False)
    """Computing time."""
    gaze_shifts: int
    """Gaze shifts from the face to an object."""
    gaze_shifts_of_all_kinds: int
    """All gaze shifts."""
    gaze_shifts_by_learner: int
    """Shifts commanded by what was learned rather than by visual feedback (eq. 6.8)."""
    learning_iterations: int
    """l of eq. 6.8: how many pairs the learner was given."""
    success: str
    """What success is held against: the file with codes, or "not known"."""
    gaze_shifts_judged: int
    """Gaze shifts of which success is known."""
    successes: int | None
    """Shifts that ended at what the person looked at, by the moment that the option ``success`` names; None where that
    is not known."""
    success_rate: float | None
    """``successes`` of ``gaze_shifts_judged``."""
    late_success_rate: float | None
    """The same over shifts that landed in the last six minutes."""
    landings_on_nothing: int
    """Shifts after which no object was within ``gaze.centre_radius_deg`` of the centre of view."""
    detected: dict[str, float | None]
    """Share of perceived frames in which each candidate was detected."""
    moves: dict[str, float | None]
    """Share of them in which it was seen to move."""
    head_reach_deg: tuple[float, float, float]
    """How far the digital head turns to either side, up and down before it comes to the border of the wide image."""
    border_share: float
    """Share of frames in which it was asked beyond."""
    notes: tuple[str, ...]
    """What a reader should know."""
    camera: CameraTimes | None = field(compare=False)
    """How well the machine kept up; None for a video."""

    RENAMED: ClassVar = {"found": "detected"}


@dataclass(frozen=True)
class Told:
    """What a session knows beside its tables."""

    minutes: float
    success: str
    reach_deg: tuple[float, float, float]
    border_share: float
    images: int
    camera: CameraTimes | None


def summarise_footage(frames: WideFrames, shifts: Shifts, told: Told, wall_seconds: float) -> FootageSessionSummary:
    """Count a session.

    Args:
        frames: All frames.
        shifts: All gaze shifts.
        told: What the tables do not hold.
        wall_seconds: Computing time.
    """
    counts = shifts.column("face_to_object") == 1
    landed, success = shifts.column("landing_s")[counts], shifts.column("success")[counts]
    judged = ~np.isnan(success)
    end = float(frames.column("time_s")[-1]) if frames.frames else 0.0
    late = judged & (landed >= end - LATE_MINUTES * 60)
    perceived = frames.column("perceived") == 1
    known = told.success != NOT_KNOWN
    detected = {name: _mean(frames.column("visible", k)[perceived]) for k, name in enumerate(frames.candidates)}
    moves = {name: _mean(frames.column("moves", k)[perceived]) for k, name in enumerate(frames.candidates)}
    return FootageSessionSummary(
        minutes=told.minutes,
        frames=frames.frames,
        images=told.images,
        wall_seconds=round(wall_seconds, 2),
        gaze_shifts=len(landed),
        gaze_shifts_of_all_kinds=len(shifts),
        gaze_shifts_by_learner=int(np.sum(shifts.column("commanded_by")[counts] == LEARNER)),
        learning_iterations=int(frames.column("iterations")[-1]) if frames.frames else 0,
        success=told.success,
        gaze_shifts_judged=int(judged.sum()),
        successes=int(np.nansum(success)) if known else None,
        success_rate=_mean(success[judged]),
        late_success_rate=_mean(success[late]),
        landings_on_nothing=int(np.sum(shifts.column("on_nothing")[counts] == 1)),
        detected=detected,
        moves=moves,
        head_reach_deg=told.reach_deg,
        border_share=told.border_share,
        notes=tuple(_notes(detected, told, len(landed), int(judged.sum()))),
        camera=told.camera,
    )


def _notes(detected: dict[str, float | None], told: Told, shifts: int, judged: int) -> list[str]:
    notes = []
    for name, share in detected.items():
        if share is not None and share < 0.5:
            notes.append(f"{name} was detected in {share:.0%} of the perceived frames")
    if told.border_share > 0.1:
        aside, up, down = told.reach_deg
        notes.append(
            f"the head was at the border of the wide image in {told.border_share:.0%} of the frames: it turns by "
            f"{aside:.0f} degrees aside, {up:.0f} up and {down:.0f} down"
        )
    if told.success != NOT_KNOWN and judged < 0.5 * shifts:
        notes.append(f"{judged} of {shifts} gaze shifts fell into time that is coded")
    return notes


def _mean(values: np.ndarray) -> float | None:
    return float(np.mean(values)) if len(values) else None
