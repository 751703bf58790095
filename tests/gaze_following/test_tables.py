"""The two tables: what goes in comes out, through pickles and Parquet."""

import pickle
from dataclasses import replace

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from jointattn_mj.gaze_following import columns, tables
from jointattn_mj.gaze_following.agent import FamiliariseConfig, GazeShift, RobotConfig
from jointattn_mj.gaze_following.scoring import Judgement, Moment
from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.gaze_following.shifts import ShiftRow, Shifts, shift_row, write_shifts
from jointattn_mj.gaze_following.tables import FrameTable, write_frames
from jointattn_mj.scene.camera import pixels_of_points

pytestmark = pytest.mark.integration

NAMES = ("red", "blue", "face")
LOCATIONS = np.array([[10.0, -15.0], [-10.0, -15.0]])


def shift(**changes) -> GazeShift:
    known = {
        "source": 2, "chosen": 0, "by_learner": False, "start": np.array([0.5, 3.0]),
        "command": np.array([10.0, -14.0]), "suggestion": np.array([9.0, -15.0]),
        "activations": None, "in_view": None, "source_direction": np.zeros(2), "reached": 0,
        "learned": True,
    }  # fmt: skip
    return GazeShift(**{**known, **changes})


def row(given: GazeShift | None = None, target: int | None = 0, judged: bool = True, head=(11.0, -14.0)) -> ShiftRow:
    launch, landing = Moment(30, "turn", target, LOCATIONS), Moment(57, "reach", target, LOCATIONS)
    judgement = Judgement(True, False, 0, 1.25) if judged else None
    return shift_row(given or shift(), launch, landing, np.array(head), 7, NAMES, judgement, judged or None, 3.5)


def test_row_by_hand():
    made = row()
    assert (made.launch_s, made.landing_s) == pytest.approx((1.0, 1.9))
    assert (made.source, made.chosen, made.reached, made.commanded_by) == ("face", "red", "red", "visual_feedback")
    assert (made.phase_at_launch, made.phase_at_landing) == ("turn", "reach")
    assert (made.target_at_launch, made.target_at_landing) == ("red", "red")
    assert (made.success, made.success_at_launch, made.success_at_landing, made.on_nothing) == (
        True,
        True,
        False,
        False,
    )
    assert (made.nearest, made.nearest_off_deg, made.iterations) == ("red", 1.25, 7)
    assert (made.pan_error_deg, made.tilt_error_deg) == pytest.approx((1.0, 1.0))
    assert made.map_error_deg == pytest.approx(np.cos(np.radians(15)))
    assert (made.start_pan_deg, made.command_tilt_deg, made.landing_pan_deg) == (0.5, -14.0, 11.0)
    assert made.face_to_object


def test_what_does_not_apply_is_missing():
    judged = ("nearest", "nearest_off_deg", "on_nothing", "success", "success_at_launch", "success_at_landing")
    errors = ("pan_error_deg", "tilt_error_deg", "map_error_deg")
    back = row(shift(source=0, chosen=2, reached=None, suggestion=None), judged=False)
    assert not back.face_to_object
    assert [getattr(back, name) for name in (*judged, *errors, "reached")] == [None] * 10
    greeting = row(target=None)
    assert [getattr(greeting, name) for name in (*errors, "target_at_launch")] == [None] * 4
    assert greeting.nearest == "red"
    first = row(shift(source=None, suggestion=None))
    assert first.source is first.map_error_deg is None


ROWS = [row(), row(shift(source=None, by_learner=True), target=None), row(judged=False), row(shift(chosen=1))]


def store(rows: list[ShiftRow]) -> Shifts:
    shifts = Shifts(NAMES)
    for shift in rows:
        shifts.append(shift)
    return shifts


def test_shifts_are_what_was_appended():
    """Values and their types, by number, from the end, in slices and one after the other."""
    shifts = store(ROWS)
    assert len(shifts) == 4
    assert list(shifts) == ROWS
    assert (shifts[0], shifts[-1], shifts[1:], shifts[::2]) == (ROWS[0], ROWS[3], ROWS[1:], ROWS[::2])
    for given, made in zip(ROWS, shifts, strict=True):
        assert [type(value) for value in vars(made).values()] == [type(value) for value in vars(given).values()]
    with pytest.raises(IndexError):
        shifts[4]
    assert shifts == store(ROWS)
    assert shifts != store(ROWS[:3])
    assert shifts != store([*ROWS[:3], ROWS[0]])


def test_columns_of_shifts():
    shifts = store(ROWS)
    assert shifts.column("commanded_by").tolist() == [0, 1, 0, 0]
    assert shifts.column("chosen").tolist() == [0, 0, 0, 1]
    np.testing.assert_array_equal(shifts.column("success"), [1, 1, np.nan, 1])
    np.testing.assert_array_equal(shifts.column("source"), [2, np.nan, 2, 2])


def test_shift_table_through_parquet(tmp_path):
    write_shifts(tmp_path / "shifts.parquet", store(ROWS))
    read = pd.read_parquet(tmp_path / "shifts.parquet")
    assert list(read.columns) == [*ShiftRow.__annotations__] == [*columns.SHIFT]
    for made, (_, kept) in zip(ROWS, read.iterrows(), strict=True):
        for name, value in vars(made).items():
            assert pd.isna(kept[name]) if value is None else kept[name] == value, name


def test_empty_shift_table(tmp_path):
    """Has the columns and their types."""
    assert store([]).table().schema == store(ROWS).table().schema
    write_shifts(tmp_path / "shifts.parquet", store([]))
    assert pd.read_parquet(tmp_path / "shifts.parquet").shape == (0, len(columns.SHIFT))


@pytest.fixture(scope="module")
def session():
    robot = RobotConfig(familiarise=FamiliariseConfig(minutes=0.05))
    session = SessionRun(SessionConfig(minutes=0.5, seed=2, perception="state", robot=robot))
    session.begin()
    for _ in range(500):
        session.step()
    yield session
    session.close()


def test_frame_table_types(session):
    table = session.frames.table()
    assert table.num_rows == 500
    candidates = session.frames.candidates
    assert candidates == ("red", "yellow", "blue", "green", "face")
    dictionary = pa.dictionary(pa.int8(), pa.string())
    for name, kind in {
        "phase": dictionary, "target": dictionary, "attended": dictionary, "perceived": pa.bool_(),
        "landed": pa.bool_(),
        "face_visible": pa.bool_(), "red_moves": pa.bool_(), "red_really_moves": pa.bool_(), "iterations": pa.int32(),
        "pan_deg": pa.float32(), "face_x_px": pa.float32(), "face_error_px": pa.float64(), "time_s": pa.float64(),
    }.items():  # fmt: skip
        assert table.schema.field(name).type == kind, name
    perceived = table["perceived"].to_numpy()
    assert 0 < perceived.sum() < 500
    np.testing.assert_array_equal(table["face_visible"].is_valid().to_numpy(), perceived)
    np.testing.assert_array_equal(
        table["red_x_px"].is_valid().to_numpy(), table["red_visible"].fill_null(False).to_numpy()
    )
    per_candidate = len(columns.CANDIDATE) - 3  # objects alone have places
    assert table.num_columns == len(columns.FRAME) + 5 * per_candidate + 4 * 3


def test_frame_table_through_a_pickle(session):
    """Goes on as if nothing had been."""
    frames = session.frames
    again = pickle.loads(pickle.dumps(frames))
    assert again.table().equals(frames.table())
    while again.frames < 900:
        again.add(session.world, session.robot, False, np.zeros(2))
    assert again.part(0, 500).table().equals(frames.table())


@pytest.mark.parametrize("group", [1, 7, 273, 499])
def test_parts_do_not_show(session, tmp_path, monkeypatch, group):
    """What is worked out from a frame and the one before is the same where these are read apart."""
    monkeypatch.setattr(tables, "GROUP", group)
    write_frames(tmp_path / "frames.parquet", session.frames)
    assert pq.read_metadata(tmp_path / "frames.parquet").num_row_groups == -(-500 // group)
    whole, read = session.frames.table(), pq.read_table(tmp_path / "frames.parquet")
    assert read.equals(whole)
    assert read.schema.equals(whole.schema, check_metadata=True)


def test_face_error_is_that_of_every_frame(session):
    """One frame after the other, bit for bit."""
    part, face = session.frames.part(), len(session.frames.candidates) - 1
    heads = np.column_stack([part.column("pan_deg"), part.column("tilt_deg")])
    real = np.array([pixels_of_points(session.world.candidate_points(), head)[face] for head in heads])
    expected = np.hypot(part.column("x_px", face) - real[:, 0], part.column("y_px", face) - real[:, 1])
    np.testing.assert_array_equal(part.face_error_px(), expected)
    assert np.isfinite(expected).sum() > 100


def test_no_frames(tmp_path):
    write_frames(tmp_path / "frames.parquet", FrameTable(("red",), 4.0, 0.05))
    assert pq.read_table(tmp_path / "frames.parquet").num_rows == 0


def test_really_moves_by_hand():
    table = FrameTable(("red",), face_above_deg_s=4.0, object_above_m_s=0.05)
    for step in (0.0, 0.001, 0.003, 0.003):  # metres; .05 m/s are 1.67 mm a frame
        values = np.zeros(table.rows.columns)
        values[table.index["x_m", 0]] = step
        values[table.index["face_yaw_deg", None]] = 100 * step  # 4 deg/s are .133 a frame
        table.rows.append(values)
    assert table.part().really_moves(0).tolist() == [False, False, True, False]
    assert table.part().really_moves(1).tolist() == [False, False, True, False]
    assert table.part(2, 4).really_moves(0).tolist() == [True, False]


def test_every_column_has_its_meaning():
    table = pa.table({"time_s": [0.0], "red_saliency": [1.0], "face_moves": [True]})
    described = columns.described(table, columns.FRAME, ("red", "face"))
    assert described.field("red_saliency").metadata[b"description"] == b"saliency S_i, eq. 6.5 and 6.6"
    with pytest.raises(KeyError, match="blue_saliency"):
        columns.described(pa.table({"blue_saliency": [1.0]}), columns.FRAME, ("red", "face"))


def test_rows_are_plain_values():
    """So that they can be compared, replaced and written as JSON."""
    assert row() == row()
    assert replace(row(), success=False) != row()
    assert {type(value) for value in vars(row()).values()} <= {float, int, bool, str, type(None)}


def test_what_a_shift_and_tables_are_fits_a_line(session):
    said = repr(row())
    assert said.startswith("ShiftRow(1.00 to 1.90 s: face to red, commanded by visual_feedback, ")
    shifts = Shifts(NAMES)
    shifts.append(row())
    assert repr(shifts) == "Shifts(1 gaze shift, 1 from the face to an object, 1 success)"
    assert repr(session.frames).startswith("FrameTable(") and repr(session.robot).startswith("GazeFollower(attends to ")
    assert max(map(len, (said, repr(session.frames), repr(session.robot)))) < 120
