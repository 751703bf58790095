"""The numbers of a summary on shifts made by hand."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jointattn_mj.errors import OutputError
from jointattn_mj.gaze_following import summary as counting
from jointattn_mj.gaze_following.shifts import ShiftRow, Shifts
from jointattn_mj.gaze_following.summary import (
    DetectionRates,
    FaceError,
    MapError,
    SessionSummary,
    moving_average,
    summarise,
)
from jointattn_mj.gaze_following.tables import FrameTable
from jointattn_mj.io.summaries import WIDTH

SHIFT = ShiftRow(
    launch_s=0, landing_s=0, source="face", chosen="red", reached="red", commanded_by="visual_feedback",
    phase_at_launch="gaze", phase_at_landing="gaze", target_at_launch="red", target_at_landing="red", start_pan_deg=0,
    start_tilt_deg=0, command_pan_deg=0, command_tilt_deg=0, landing_pan_deg=0, landing_tilt_deg=0, learned=True,
    iterations=1, face_to_object=True, nearest="red", nearest_off_deg=1, on_nothing=False, success_at_launch=True,
    success_at_landing=True, success=True, pan_error_deg=0, tilt_error_deg=0, map_error_deg=3.0,
)  # fmt: skip
MISS = replace(SHIFT, success=False, success_at_launch=False, success_at_landing=False)
BACK = replace(SHIFT, source="red", face_to_object=False, success=None, map_error_deg=None)


def at(minute: float, shift: ShiftRow) -> ShiftRow:
    return replace(shift, landing_s=60 * minute)


def no_frames() -> FrameTable:
    return FrameTable(("red", "blue"), 4.0, 0.05)


def table(rows: list[ShiftRow]) -> Shifts:
    shifts = Shifts(("red", "blue", "face"))
    for row in rows:
        shifts.append(row)
    return shifts


def test_moving_average_by_hand():
    """Eq. 6.9: from t-1 to t+1, ends included; shifts back to the face do not count."""
    shifts = [at(0.5, SHIFT), at(1.0, MISS), at(2.0, SHIFT), at(2.2, BACK), at(2.9, MISS), at(4.1, SHIFT)]
    times, rate = moving_average(table(shifts), 6)
    assert times.tolist() == [1, 2, 3, 4, 5]
    np.testing.assert_allclose(rate, [2 / 3, 1 / 3, 1 / 2, 1, 1])
    times, rate = moving_average(table(shifts[:2]), 6)
    np.testing.assert_allclose(rate, [1 / 2, 0, np.nan, np.nan, np.nan])


def test_moving_average_of_26_minutes_runs_from_1_to_25():
    assert moving_average(table([]), 26)[0].tolist() == list(range(1, 26))
    assert np.isnan(moving_average(table([]), 26)[1]).all()
    assert len(moving_average(table([]), 0.3)[0]) == 1


@given(st.lists(st.tuples(st.floats(0, 10), st.booleans()), max_size=30))
def test_moving_average_against_plain_python(given):
    shifts = [at(minute, SHIFT if good else MISS) for minute, good in given]
    times, rate = moving_average(table(shifts), 10)
    for time, value in zip(times, rate, strict=True):
        near = [row.success for row in shifts if abs(row.landing_s / 60 - time) <= 1]
        assert value == pytest.approx(np.mean(near)) if near else np.isnan(value)


def test_counts_by_hand():
    launch_only = replace(SHIFT, success_at_landing=False)
    landing_only = replace(SHIFT, success_at_launch=False, on_nothing=True)
    by_learner = replace(MISS, commanded_by="learner", map_error_deg=9.0)
    rows = [at(1, SHIFT), at(2, launch_only), at(3, landing_only), at(21, by_learner), at(25, SHIFT), at(25.5, BACK)]
    summary = summarise(no_frames(), table(rows), 26.0, 12.345)
    assert (summary.minutes, summary.wall_seconds) == (26.0, 12.35)
    assert summary.gaze_shifts == 5
    assert summary.gaze_shifts_of_all_kinds == 6
    assert summary.successes == 4
    assert summary.successes_at_launch == 3
    assert summary.successes_at_landing == 3
    assert summary.landings_on_nothing == 1
    assert summary.successes_on_an_object == 3
    assert summary.success_rate == pytest.approx(4 / 5)
    assert summary.late_success_rate == pytest.approx(1 / 2)  # from the 20th minute on
    assert summary.gaze_shifts_by_learner == 1
    assert summary.map_error_deg == MapError(6.0, 2)


def test_nothing_happened():
    """None where there is nothing to count, never a division by zero or NaN, which is no JSON."""
    summary = summarise(no_frames(), table([]), 26.0, 0.0)
    assert summary.gaze_shifts == summary.successes == summary.learning_iterations == summary.frames == 0
    for value in (summary.success_rate, summary.late_success_rate, summary.map_error_deg.median):
        assert value is None
    assert summary.motion_detection.face == DetectionRates(None, None)
    assert summary.face_error_px == FaceError(None, None, None)
    assert summary.face_missed_share is None


@pytest.mark.parametrize("part", [1, 3, 100])
def test_motion_rates_by_hand(monkeypatch, part):
    """Landing frames and frames of a turning head do not count; in how many parts they are counted makes no
    difference."""
    monkeypatch.setattr(counting, "PART", part)
    frames = FrameTable(("red",), 4.0, 0.05)
    moved = [0, 1, 1, 1, 0, 0, 1, 1]  # really, since the frame before
    values = np.zeros((8, frames.rows.columns))
    for name, candidate, column in (
        ("x_m", 0, 0.01 * np.cumsum(moved)),
        ("moves", 0, [1, 1, 1, 0, 0, 1, 0, 0]),
        ("landed", None, [0, 0, 0, 0, 0, 0, 1, 0]),
        ("head_moves", None, [0, 0, 0, 0, 0, 0, 0, 1]),
        ("perceived", None, np.ones(8)),
    ):
        values[:, frames.index[name, candidate]] = column
    for row in values:
        frames.rows.append(row)
    motion = summarise(frames, table([]), 1.0, 0.0).motion_detection
    assert motion.objects == DetectionRates(pytest.approx(2 / 3), pytest.approx(2 / 3))
    assert motion.face == DetectionRates(None, 0)


def test_keys_of_the_last_version():
    """They give the same values and name the new key; a file that has them is read."""
    summary = summarise(no_frames(), table([at(1, SHIFT)]), 26.0, 1.0)
    with pytest.warns(FutureWarning, match="'late_rate' is now called 'late_success_rate'"):
        assert summary["late_rate"] == summary.late_success_rate
    with pytest.warns(FutureWarning, match="median_px"):
        assert summary.face_error_px["p50"] is None
    assert summary["successes"] == 1
    with pytest.raises(KeyError, match="there are minutes, frames"):
        summary["failures"]
    before = summary.by_old_keys()
    assert before["motion"] == {
        "face": {"hit_rate": None, "false_alarm_rate": None},
        "objects": before["motion"]["objects"],
    }
    assert list(before["face_error_px"]) == ["p50", "p95", "above_8px"]
    with pytest.warns(FutureWarning, match="SessionSummary.late_rate is now called late_success_rate"):
        read = SessionSummary.of(before)
    assert read == SessionSummary.of(summary.plain()) == summary


def test_a_summary_that_is_not_one(tmp_path):
    with pytest.raises(OutputError, match="give the folder of a finished run"):
        SessionSummary.read(tmp_path / "summary.json")
    (tmp_path / "summary.json").write_text("{}")
    with pytest.raises(OutputError, match="missing or unknown"):
        SessionSummary.read(tmp_path / "summary.json")
    (tmp_path / "summary.json").write_text("3")
    with pytest.raises(OutputError, match="cannot read"):
        SessionSummary.read(tmp_path / "summary.json")


def test_a_summary_in_a_line_and_in_a_table():
    summary = summarise(no_frames(), table([at(1, SHIFT)]), 26.0, 1.0)
    assert len(repr(summary)) <= WIDTH and repr(summary).startswith("SessionSummary(minutes=26, frames=0,")
    assert "motion_detection.face.hit_rate" in str(summary) and len(str(summary).splitlines()) == 25
