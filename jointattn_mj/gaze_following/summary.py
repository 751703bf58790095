"""A session in numbers: what ``summary.json`` holds."""

from typing import Any

import numpy as np

from jointattn_mj.gaze_following.shifts import COMMANDERS, Shifts
from jointattn_mj.gaze_following.tables import FramePart, FrameTable

LEARNER = COMMANDERS.index("learner")
PART = 1 << 13
"""Frames that are counted at a time."""

LATE_MINUTES = 6.0
"""The end of a session, over which its final rate of success is taken ("after about 20 minutes" of 26, 6.4.3)."""


def rate_of_success(times: np.ndarray, at: np.ndarray, success: np.ndarray) -> np.ndarray:
    """mov_ave(t), eq. 6.9, at any ``times``: the share of successes among shifts within a minute of each; NaN if none.

    Args:
        times: (m,) minutes.
        at: (k,) when the shifts landed, minutes.
        success: (k,) bool.
    """
    rate = np.full(len(times), np.nan)
    for number, time in enumerate(times):
        near = success[np.abs(at - time) <= 1]
        if len(near):
            rate[number] = near.sum() / len(near)
    return rate


def moving_average(shifts: Shifts, minutes: float) -> tuple[np.ndarray, np.ndarray]:
    """mov_ave(t), eq. 6.9, at every full minute: (t, rate), each (m,); NaN where nothing happened."""
    counts = shifts.column("face_to_object") == 1
    times = np.arange(1, max(2, int(np.ceil(minutes))))
    at, success = shifts.column("landing_s")[counts] / 60, shifts.column("success")[counts] == 1
    return times, rate_of_success(times, at, success)


def summarise(frames: FrameTable, shifts: Shifts, minutes: float, wall_seconds: float) -> dict[str, Any]:
    """All of it as JSON-ready numbers; None where there was nothing to count."""
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
    return {
        "minutes": minutes,
        "frames": frames.frames,
        "rendered_frames": int(frames.column("rendered").sum()),
        "wall_seconds": round(wall_seconds, 2),
        "gaze_shifts": len(landed),
        "gaze_shifts_of_all_kinds": len(shifts),
        "successes": int(success.sum()),
        "successes_at_launch": int(at_launch.sum()),
        "successes_at_landing": int(at_landing.sum()),
        "landings_on_nothing": int(on_nothing.sum()),
        "successes_on_something": int(np.sum(success & ~on_nothing)),
        "success_rate": _ratio(success.sum(), len(landed)),
        "late_rate": _ratio(success[late].sum(), late.sum()),
        "commanded_by_learner": int(by_learner.sum()),
        "learning_iterations": int(frames.recent(1).column("iterations")[-1]) if frames.frames else 0,
        **_perception(frames),
        "map_error_deg": {"median": float(np.median(map_errors)) if len(map_errors) else None, "n": len(map_errors)},
    }


def _perception(frames: FrameTable) -> dict[str, Any]:
    """How well motion and the face were seen, counted part by part."""
    face = len(frames.candidates) - 1
    of_face, of_objects = np.zeros(4, int), np.zeros(4, int)
    errors, known, looked, missed = np.empty(frames.frames), 0, 0, 0
    for part in frames.parts(PART):
        of_face += _motion(part, [face])
        of_objects += _motion(part, list(range(face)))
        found = part.face_error_px()
        found = found[~np.isnan(found)]
        errors[known : known + len(found)] = found
        known += len(found)
        looked += int(np.sum(part.column("perceived") == 1))
        missed += int(np.sum(part.column("visible", face) == 0))
    errors = errors[:known]
    above = float(np.mean(errors > 8)) if known else None
    p50, p95 = np.percentile(errors, (50, 95), overwrite_input=True).tolist() if known else (None, None)
    return {
        "motion": {"face": _rates(of_face), "objects": _rates(of_objects)},
        "face_error_px": {"p50": p50, "p95": p95, "above_8px": above},
        "face_missed": _ratio(missed, looked),
    }


def _motion(part: FramePart, candidates: list[int]) -> np.ndarray:
    """(4,) hits, moving, false alarms and still, over candidates and frames of fixation (a landing frame has no motion
    yet)."""
    fixation = (part.column("perceived") == 1) & (part.column("landed") == 0) & (part.column("head_moves") == 0)
    said = np.concatenate([part.column("moves", k)[fixation] for k in candidates]) == 1
    real = np.concatenate([part.really_moves(k)[fixation] for k in candidates])
    return np.array([np.sum(said & real), np.sum(real), np.sum(said & ~real), np.sum(~real)])


def _rates(counts: np.ndarray) -> dict[str, float | None]:
    hits, moving, alarms, still = counts
    return {"hit_rate": _ratio(hits, moving), "false_alarm_rate": _ratio(alarms, still)}


def _ratio(part: float, whole: float) -> float | None:
    return float(part / whole) if whole else None
