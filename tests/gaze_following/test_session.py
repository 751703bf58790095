"""Two minutes of a session from the state: what is logged is what happened, counted again from the files."""

import json
import math

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
import yaml

from jointattn_mj.errors import ConfigError
from jointattn_mj.gaze_following.agent import FamiliariseConfig, RobotConfig
from jointattn_mj.gaze_following.run import SessionOptions, run_session
from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.io.weights import read_weights
from jointattn_mj.scene.camera import directions_to, pixels_of_points
from jointattn_mj.scene.caregiver import FRAME_S, Phase

pytestmark = pytest.mark.integration

OBJECTS = ("red", "yellow", "blue", "green")
CANDIDATES = (*OBJECTS, "face")
ROBOT = RobotConfig(familiarise=FamiliariseConfig(minutes=0.3))
CONFIG = SessionConfig(minutes=2, seed=4, perception="state", robot=ROBOT)


class Files:
    """What a session left, read with pandas."""

    def __init__(self, out):
        self.out = out
        self.summary = json.loads((out / "summary.json").read_text())
        self.frames = pd.read_parquet(out / "frames.parquet")
        self.shifts = pd.read_parquet(out / "gaze_shifts.parquet")
        self.to_objects = self.shifts[self.shifts.face_to_object]


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> Files:
    out = tmp_path_factory.mktemp("session")
    run_session(CONFIG, SessionOptions(out))
    return Files(out)


@pytest.fixture(scope="module")
def run() -> dict[str, np.ndarray]:
    """The same session, watched as it happens."""
    session = SessionRun(CONFIG)
    session.begin()
    visible: dict[str, list] = {name: [] for name in ("moving", "face_off", "head", "phase", "objects")}

    def watch(session: SessionRun) -> None:
        world, percept = session.world, session.robot.percept
        above = session.config.state
        visible["moving"].append(world.moving(above.face_moves_above_deg_s, above.object_moves_above_m_s))
        head = np.degrees(world.head_angles())
        face = pixels_of_points(world.candidate_points(), head)[-1]
        visible["face_off"].append(np.nan if percept is None else np.linalg.norm(percept.px[-1] - face))
        visible["head"].append(head)
        visible["phase"].append(str(world.caregiver.phase))
        visible["objects"].append(world.caregiver.objects.copy())

    while session.frame < session.total:
        session.step(watch)
    session.close()
    return {name: np.array(values) for name, values in visible.items()}


def test_a_summary_has_its_fields(files):
    assert {
        "minutes", "frames", "rendered_frames", "wall_seconds", "gaze_shifts", "successes", "successes_at_launch",
        "successes_at_landing", "landings_on_nothing", "late_success_rate", "motion_detection", "face_error_px",
        "map_error_deg",
    } <= files.summary.keys()  # fmt: skip
    for kind in ("face", "objects"):
        assert files.summary["motion_detection"][kind].keys() == {"hit_rate", "false_alarm_rate"}
    assert {"median_px", "percentile_95_px"} <= files.summary["face_error_px"].keys()
    assert "median" in files.summary["map_error_deg"]
    assert files.summary["minutes"] == 2
    assert files.summary["frames"] == 3600 == len(files.frames)
    assert files.summary["rendered_frames"] == 0
    assert files.summary["wall_seconds"] > 0


def test_counts_again(files):
    summary, rows = files.summary, files.to_objects
    assert summary["gaze_shifts"] == len(rows) > 10
    assert summary["gaze_shifts_of_all_kinds"] == len(files.shifts)
    assert summary["successes"] == rows.success.sum() > 0
    assert summary["successes_at_launch"] == rows.success_at_launch.sum()
    assert summary["successes_at_landing"] == rows.success_at_landing.sum()
    assert summary["landings_on_nothing"] == rows.on_nothing.sum()
    assert summary["successes_on_an_object"] == (rows.success.astype(bool) & ~rows.on_nothing.astype(bool)).sum()
    assert summary["success_rate"] == pytest.approx(rows.success.mean())
    assert summary["late_success_rate"] == pytest.approx(rows.success.mean())  # two minutes are all late
    assert summary["gaze_shifts_by_learner"] == (rows.commanded_by == "learner").sum()
    assert summary["learning_iterations"] == files.frames.iterations.iloc[-1] == rows.learned.sum()
    assert summary["map_error_deg"]["median"] == pytest.approx(rows.map_error_deg.median())
    assert summary["map_error_deg"]["n"] == rows.map_error_deg.notna().sum()


def test_perception_counts_again(files):
    frames = files.frames
    fixation = frames[frames.perceived.astype(bool) & ~frames.landed.astype(bool) & ~frames.head_moves.astype(bool)]
    for kind, names in (("face", ("face",)), ("objects", OBJECTS)):
        said = np.concatenate([fixation[f"{name}_moves"].astype(bool) for name in names])
        real = np.concatenate([fixation[f"{name}_really_moves"].astype(bool) for name in names])
        assert files.summary["motion_detection"][kind]["hit_rate"] == pytest.approx(said[real].mean())
        assert files.summary["motion_detection"][kind]["false_alarm_rate"] == pytest.approx(said[~real].mean())
        assert files.summary["motion_detection"][kind]["hit_rate"] > 0.9
    errors = frames.face_error_px.dropna()
    assert files.summary["face_error_px"]["median_px"] == pytest.approx(errors.median(), rel=1e-6)
    assert files.summary["face_error_px"]["percentile_95_px"] == pytest.approx(errors.quantile(0.95), rel=1e-6)
    assert files.summary["face_error_px"]["share_above_8_px"] == pytest.approx((errors > 8).mean())


def test_columns_say_what_they_mean(files):
    for name in ("frames", "gaze_shifts"):
        for field in pq.read_schema(files.out / f"{name}.parquet"):
            assert len(field.metadata[b"description"]) > 5, field.name


def test_frames_are_what_happened(files, run):
    frames = files.frames
    np.testing.assert_allclose(frames.time_s, np.arange(3600) / 30)
    np.testing.assert_allclose(frames[["pan_deg", "tilt_deg"]], run["head"], atol=1e-4)
    np.testing.assert_array_equal(frames.phase.astype(str), run["phase"])
    assert set(frames.phase.cat.categories) == {str(phase) for phase in Phase}
    for number, name in enumerate(OBJECTS):
        locations = frames[[f"{name}_{axis}_m" for axis in "xyz"]]
        np.testing.assert_allclose(locations, run["objects"][:, number], atol=1e-6)
    np.testing.assert_allclose(frames.face_error_px.astype(float), run["face_off"], atol=2e-3)
    agree = [
        np.mean(frames[f"{name}_really_moves"].to_numpy(bool)[1:] == run["moving"][1:, number])
        for number, name in enumerate(CANDIDATES)
    ]
    assert min(agree) > 0.999  # single precision at the threshold


def test_interest_follows_the_equations(files):
    """Eq. 6.1 and 6.4 in every row, eq. 6.3 and 6.6 from each fixated row to the next; frozen while the head turns."""
    frames = files.frames
    grows = (frames.perceived.astype(bool) & ~frames.landed.astype(bool)).to_numpy()[1:]
    for name in CANDIDATES:
        saliency, motion, interest, moves = (
            frames[f"{name}_{column}"].astype(float).to_numpy()
            for column in ("saliency", "motion", "interest", "moves")
        )
        np.testing.assert_allclose(interest, saliency * (1 + 4.5 / (1 + np.exp((20 - motion) / 1.4))), rtol=1e-4)
        assert (np.diff(motion)[~grows] == 0).all()
        assert (np.diff(saliency)[~grows] == 0).all()
        expected = np.where(moves[1:] == 1, motion[:-1] + 1, np.maximum(motion[:-1] - 1, 0))
        np.testing.assert_array_equal(motion[1:][grows], expected[grows])
        preference, decay, growth = (1500, 2e-2, 1.2e-2) if name == "face" else (800, 1e-2, 2e-3)
        attended = (frames.attended.shift(1) == name).to_numpy()[1:]  # attended when the frame began
        grown = np.minimum(preference, np.exp(growth) * saliency[:-1])
        expected = np.where(attended, np.exp(-decay) * saliency[:-1], grown)
        np.testing.assert_allclose(saliency[1:][grows], expected[grows], rtol=1e-5)


def test_shifts_and_frames_agree(files):
    frames, shifts = files.frames, files.shifts
    landed = frames[frames.landed.astype(bool)]
    np.testing.assert_allclose(landed.time_s, shifts.landing_s)
    np.testing.assert_allclose(landed.pan_deg, shifts.landing_pan_deg, atol=1e-4)
    launched = (shifts.launch_s / FRAME_S).round().astype(int)
    landing = (shifts.landing_s / FRAME_S).round().astype(int)
    assert (launched.iloc[1:].to_numpy() >= landing.iloc[:-1].to_numpy()).all()
    assert (landing - launched).between(26, 30).all()  # "about one second"
    turning = np.zeros(len(frames), bool)
    for first, last in zip(launched, landing, strict=True):
        turning[first:last] = True
    unfinished = landing.iloc[-1]  # a shift that is under way at the end has no row
    np.testing.assert_array_equal(frames.head_moves.to_numpy(bool)[:unfinished], turning[:unfinished])
    for moment, at in (("launch", launched), ("landing", landing)):
        for column, frame_column in ((f"phase_at_{moment}", "phase"), (f"target_at_{moment}", "target")):
            assert list(shifts[column].fillna("-")) == list(frames[frame_column].astype(object).fillna("-").iloc[at])


def test_scoring_counts_again(files):
    """Success at launch and at landing, worked out anew from the places of the objects in the frames."""
    for row in files.to_objects.itertuples():
        head = np.array([row.landing_pan_deg, row.landing_tilt_deg])

        def nearest(seconds: float, head=head) -> tuple[str, float]:
            frame = files.frames.iloc[round(seconds / FRAME_S)]
            locations = np.array([[frame[f"{name}_{axis}_m"] for axis in "xyz"] for name in OBJECTS])
            off = (directions_to(locations) - head) * [math.cos(math.radians(head[1])), 1]
            distance = np.linalg.norm(off, axis=1)
            return OBJECTS[distance.argmin()], distance.min()

        assert row.source == "face"
        now, distance = nearest(row.landing_s)
        assert row.nearest == now
        assert row.nearest_off_deg == pytest.approx(distance, abs=1e-3)
        assert row.on_nothing == (distance > 3.5)
        assert row.success_at_landing == (now == row.target_at_landing)
        assert row.success_at_launch == (nearest(row.launch_s)[0] == row.target_at_launch)
        assert row.success == (row.success_at_launch or row.success_at_landing)


def test_only_shifts_from_the_face_are_judged(files):
    others = files.shifts[~files.shifts.face_to_object]
    assert len(others) > 10
    assert (others.source.fillna("-") != "face").all()
    assert others[["success", "nearest", "on_nothing", "map_error_deg"]].isna().all(axis=None)
    assert (others.reached[others.learned] == "face").all()


@pytest.mark.parametrize("success", ["launch", "landing"])
def test_what_counts_as_success_is_an_option(files, success):
    """It changes nothing but the count."""
    session = SessionRun(SessionConfig(minutes=1, seed=4, perception="state", robot=ROBOT, success=success))
    session.begin()
    while session.frame < session.total:
        session.step()
    session.close()
    rows = [row for row in session.shifts if row.face_to_object]
    first_minute = files.to_objects[files.to_objects.landing_s < 60]
    assert [row.success for row in rows] == list(first_minute[f"success_at_{success}"])
    assert session.summary(1.0)["successes"] == first_minute[f"success_at_{success}"].sum()


def test_folder(files):
    written = yaml.safe_load((files.out / "config.yaml").read_text())
    assert written["config"]["seed"] == 4
    assert written["config"]["robot"]["attention"]["recovery"] == "min"
    assert {"jointattn_mj", "mujoco", "numpy"} <= written["versions"].keys()
    weights = read_weights(files.out / "weights.npz")
    assert weights["learner"].shape[1:] == (21, 11)
    assert weights["iterations"] == files.summary["learning_iterations"]
    for name in ("success.png", "som.png"):
        assert (files.out / name).read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("options", [{"minutes": 0}, {"minutes": math.nan}, {"minutes": math.inf}, {"seed": -1}])
def test_impossible_options(options):
    with pytest.raises(ConfigError, match=next(iter(options))):
        SessionConfig(**options)
