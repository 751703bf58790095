"""A session in numbers: what ``summary.json`` holds."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from jointattn_mj.gaze_following.shifts import COMMANDERS, Shifts
from jointattn_mj.gaze_following.tables import FramePart, FrameTable
from jointattn_mj.io.summaries import Summary

LEARNER = COMMANDERS.index("learner")
PART = 1 << 13
"""Frames counted at a time."""

LATE_MINUTES = 6.0
"""Length of the end of a session that the late success rate is taken over ("after about 20 minutes" of 26, 6.4.3)."""


@dataclass(frozen=True, repr=False)
class DetectionRates(Summary):
    """How well motion was detected, over frames of fixation; None where there was no such frame."""

    hit_rate: float | None
    """Share of frames with real motion in which motion was detected."""
    false_alarm_rate: float | None
    """Share of frames without real motion in which motion was detected."""


@dataclass(frozen=True, repr=False)
class MotionDetection(Summary):
    """How well motion was detected (eq. 6.3)."""

    face: DetectionRates
    """Of the caregiver's face."""
    objects: DetectionRates
    """Of all objects together."""


@dataclass(frozen=True, repr=False)
class FaceError(Summary):
    """Distance of the detected face from the real one, pixels; None where no face was detected."""

    median_px: float | None
    """Half of the distances are smaller."""
    percentile_95_px: float | None
    """95 of 100 distances are smaller."""
    share_above_8_px: float | None
    """Share of distances above 8 pixels, a quarter of the patch that the robot learns from."""

    RENAMED: ClassVar = {"p50": "median_px", "p95": "percentile_95_px", "above_8px": "share_above_8_px"}


@dataclass(frozen=True, repr=False)
class MapError(Summary):
    """Angle between what the learner suggested and the direction of the caregiver's target, over the late shifts."""

    median: float | None
    """Degrees; None where there was no such shift."""
    n: int
    """Number of shifts."""


@dataclass(frozen=True, repr=False)
class SessionSummary(Summary):
    """A session in numbers. Rates are shares of 1, and None where there was nothing to count.

    ``gaze_shifts`` and all counts of successes are about shifts from the caregiver's face to an object. Two summaries
    are equal if all but ``wall_seconds`` is.

    Examples:
        >>> from jointattn_mj import Session
        >>> summary = Session(minutes=0.2, perception="state", seed=0).run().summary
        >>> summary.frames, summary.minutes
        (360, 0.2)
        >>> summary.successes <= summary.gaze_shifts <= summary.gaze_shifts_of_all_kinds
        True
    """

    minutes: float
    """Simulated minutes."""
    frames: int
    """Simulated frames, 30 a second."""
    rendered_frames: int
    """Frames of which an image was rendered for the robot."""
    wall_seconds: float = field(compare=False)
    """Computing time."""
    gaze_shifts: int
    """Gaze shifts from the face to an object."""
    gaze_shifts_of_all_kinds: int
    """All gaze shifts."""
    successes: int
    """Shifts that landed on what the caregiver looked at, by the moment that the option ``success`` names."""
    successes_at_launch: int
    """Shifts that landed on what the caregiver looked at when the shift began."""
    successes_at_landing: int
    """Shifts that landed on what the caregiver looked at when the shift ended."""
    landings_on_nothing: int
    """Shifts after which no object was within ``gaze.centre_radius_deg`` of the centre of view."""
    successes_on_an_object: int
    """Successes after which an object was that near to the centre of view."""
    success_rate: float | None
    """``successes`` of ``gaze_shifts``."""
    late_success_rate: float | None
    """The same over shifts that landed in the last six minutes."""
    gaze_shifts_by_learner: int
    """Shifts commanded by what was learned rather than by visual feedback (eq. 6.8)."""
    learning_iterations: int
    """l of eq. 6.8: how many pairs the learner was given."""
    motion_detection: MotionDetection
    """How well the robot detected motion."""
    face_error_px: FaceError
    """How far from the real face the detected one was."""
    face_missed_share: float | None
    """Share of perceived frames in which no face was detected."""
    map_error_deg: MapError
    """How wrong the learned map was at the end."""

    RENAMED: ClassVar = {
        "successes_on_something": "successes_on_an_object",
        "late_rate": "late_success_rate",
        "commanded_by_learner": "gaze_shifts_by_learner",
        "motion": "motion_detection",
        "face_missed": "face_missed_share",
    }


def rate_of_success(times: np.ndarray, at: np.ndarray, success: np.ndarray) -> np.ndarray:
    """mov_ave(t), eq. 6.9: share of successes among the shifts that landed within a minute of each time; NaN if none.

    Args:
        times: (m,) minutes.
        at: (k,) times at which shifts landed, minutes.
        success: (k,) bool, whether each was a success.
    """
    rate = np.full(len(times), np.nan)
    for number, time in enumerate(times):
        near = success[np.abs(at - time) <= 1]
        if len(near):
            rate[number] = near.sum() / len(near)
    return rate


def moving_average(shifts: Shifts, minutes: float) -> tuple[np.ndarray, np.ndarray]:
    """mov_ave(t), eq. 6.9, at every full minute: (t, rate), each (m,); NaN where nothing happened."""
    counts = (shifts.column("face_to_object") == 1) & ~np.isnan(shifts.column("success"))
    times = np.arange(1, max(2, int(np.ceil(minutes))))
    at, success = shifts.column("landing_s")[counts] / 60, shifts.column("success")[counts] == 1
    return times, rate_of_success(times, at, success)


def summarise(frames: FrameTable, shifts: Shifts, minutes: float, wall_seconds: float) -> SessionSummary:
    """Count a session.

    Args:
        frames: All frames.
        shifts: All gaze shifts.
        minutes: Simulated minutes of the session; its late shifts landed in the last six of them.
        wall_seconds: Computing time.
    """
    counts = shifts.column("face_to_object") == 1
    landed = shifts.column("landing_s")[counts]
    at_launch, at_landing, on_nothing, success, by_learner = (
        shifts.column(name)[counts] == yes
        for name, yes in (
            ("success_at_launch", 1), ("success_at_landing", 1), ("on_nothing", 1), ("success", 1),
            ("commanded_by", LEARNER),
        )
    )  # fmt: skip
    late = landed >= (minutes - LATE_MINUTES) * 60
    map_errors = shifts.column("map_error_deg")[counts][late]
    map_errors = map_errors[~np.isnan(map_errors)]
    motion, face_error, face_missed = _perception(frames)
    return SessionSummary(
        minutes=minutes,
        frames=frames.frames,
        rendered_frames=int(frames.column("rendered").sum()),
        wall_seconds=round(wall_seconds, 2),
        gaze_shifts=len(landed),
        gaze_shifts_of_all_kinds=len(shifts),
        successes=int(success.sum()),
        successes_at_launch=int(at_launch.sum()),
        successes_at_landing=int(at_landing.sum()),
        landings_on_nothing=int(on_nothing.sum()),
        successes_on_an_object=int(np.sum(success & ~on_nothing)),
        success_rate=_ratio(success.sum(), len(landed)),
        late_success_rate=_ratio(success[late].sum(), late.sum()),
        gaze_shifts_by_learner=int(by_learner.sum()),
        learning_iterations=int(frames.recent(1).column("iterations")[-1]) if frames.frames else 0,
        motion_detection=motion,
        face_error_px=face_error,
        face_missed_share=face_missed,
        map_error_deg=MapError(float(np.median(map_errors)) if len(map_errors) else None, len(map_errors)),
    )


def _perception(frames: FrameTable) -> tuple[MotionDetection, FaceError, float | None]:
    """How well motion and the face were detected, and how often the face was missed; counted part by part."""
    face = len(frames.candidates) - 1
    of_face, of_objects = np.zeros(4, int), np.zeros(4, int)
    errors, known, perceived, missed = np.empty(frames.frames), 0, 0, 0
    for part in frames.parts(PART):
        of_face += _motion(part, [face])
        of_objects += _motion(part, list(range(face)))
        error = part.face_error_px()
        error = error[~np.isnan(error)]
        errors[known : known + len(error)] = error
        known += len(error)
        perceived += int(np.sum(part.column("perceived") == 1))
        missed += int(np.sum(part.column("visible", face) == 0))
    errors = errors[:known]
    above = float(np.mean(errors > 8)) if known else None
    p50, p95 = np.percentile(errors, (50, 95), overwrite_input=True).tolist() if known else (None, None)
    return MotionDetection(_rates(of_face), _rates(of_objects)), FaceError(p50, p95, above), _ratio(missed, perceived)


def _motion(part: FramePart, candidates: list[int]) -> np.ndarray:
    """(4,) counts of hits, real motion, false alarms and no motion, over candidates and frames of fixation.

    A frame in which a shift has just landed does not count: its motion is not known yet.
    """
    fixation = (part.column("perceived") == 1) & (part.column("landed") == 0) & (part.column("head_moves") == 0)
    detected = np.concatenate([part.column("moves", k)[fixation] for k in candidates]) == 1
    real = np.concatenate([part.really_moves(k)[fixation] for k in candidates])
    return np.array([np.sum(detected & real), np.sum(real), np.sum(detected & ~real), np.sum(~real)])


def _rates(counts: np.ndarray) -> DetectionRates:
    hits, moving, alarms, still = counts
    return DetectionRates(_ratio(hits, moving), _ratio(alarms, still))


def _ratio(part: float, whole: float) -> float | None:
    return float(part / whole) if whole else None
