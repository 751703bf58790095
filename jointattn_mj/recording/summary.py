"""A session in numbers: what ``summary.json`` holds."""

from typing import Any

import numpy as np

from jointattn_mj.recording.tables import FrameTable, ShiftRow

LATE_MINUTES = 6.0
"""The end of a session, over which its final rate of success is taken ("after about 20 minutes" of 26, 6.4.3)."""


def rate_of_success(times: np.ndarray, at: np.ndarray, success: np.ndarray) -> np.ndarray:
    """mov_ave(t), eq. 6.9, at any ``times``: the share of successes among shifts within a minute of each; NaN if none.

    Args:
        times: (m,) minutes.
        at: (k,) when the shifts landed, minutes.
        success: (k,) bool.
    """
    within = np.abs(at[None] - times[:, None]) <= 1
    count = within.sum(axis=1)
    return np.where(count, (within & success).sum(axis=1) / np.maximum(count, 1), np.nan)


def moving_average(shifts: list[ShiftRow], minutes: float) -> tuple[np.ndarray, np.ndarray]:
    """mov_ave(t), eq. 6.9, at every full minute: (t, rate), each (m,); NaN where nothing happened."""
    rows = [row for row in shifts if row.face_to_object]
    at = np.array([row.landing_s / 60 for row in rows])
    success = np.array([row.success for row in rows], bool)
    times = np.arange(1, max(2, int(np.ceil(minutes))))
    return times, rate_of_success(times, at, success)


def summarise(frames: FrameTable, shifts: list[ShiftRow], minutes: float, wall_seconds: float) -> dict[str, Any]:
    """All of it as JSON-ready numbers; None where there was nothing to count."""
    rows = [row for row in shifts if row.face_to_object]
    late = [row for row in rows if row.landing_s >= (minutes - LATE_MINUTES) * 60]
    success = int(sum(bool(row.success) for row in rows))
    errors = frames.face_error_px()
    errors = errors[~np.isnan(errors)]
    face = len(frames.candidates) - 1
    map_errors = [row.map_error_deg for row in late if row.map_error_deg is not None]
    return {
        "minutes": minutes,
        "frames": frames.frames,
        "rendered_frames": int(frames.column("rendered").sum()),
        "wall_seconds": round(wall_seconds, 2),
        "gaze_shifts": len(rows),
        "gaze_shifts_of_all_kinds": len(shifts),
        "successes": success,
        "successes_at_launch": int(sum(bool(row.success_at_launch) for row in rows)),
        "successes_at_landing": int(sum(bool(row.success_at_landing) for row in rows)),
        "landings_on_nothing": int(sum(bool(row.on_nothing) for row in rows)),
        "successes_on_something": int(sum(bool(row.success) and not row.on_nothing for row in rows)),
        "success_rate": _ratio(success, len(rows)),
        "late_rate": _ratio(sum(bool(row.success) for row in late), len(late)),
        "commanded_by_learner": int(sum(row.commanded_by == "learner" for row in rows)),
        "learning_iterations": int(frames.column("iterations")[-1]) if frames.frames else 0,
        "motion": {
            "face": _detection(frames, [face]),
            "objects": _detection(frames, list(range(face))),
        },
        "face_error_px": {
            "p50": float(np.percentile(errors, 50)) if len(errors) else None,
            "p95": float(np.percentile(errors, 95)) if len(errors) else None,
            "above_8px": float(np.mean(errors > 8)) if len(errors) else None,
        },
        "face_missed": _ratio(np.sum(frames.column("seen", face) == 0), frames.column("looked").sum()),
        "map_error_deg": {"median": float(np.median(map_errors)) if map_errors else None, "n": len(map_errors)},
    }


def _detection(frames: FrameTable, candidates: list[int]) -> dict[str, float | None]:
    """Hit and false-alarm rate of motion flags over the frames of fixation (a landing frame has no motion yet)."""
    fixation = (frames.column("looked") == 1) & (frames.column("landed") == 0) & (frames.column("head_moves") == 0)
    said = np.concatenate([frames.column("moves", k)[fixation] for k in candidates]) == 1
    real = np.concatenate([frames.really_moves(k)[fixation] for k in candidates])
    return {
        "hit_rate": _ratio(np.sum(said & real), np.sum(real)),
        "false_alarm_rate": _ratio(np.sum(said & ~real), np.sum(~real)),
    }


def _ratio(part: float, whole: float) -> float | None:
    return float(part / whole) if whole else None
