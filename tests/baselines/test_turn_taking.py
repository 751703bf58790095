"""Tables, rendered faces, and attempts: who commands, what is learned, what counts."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from jointattn_mj.baselines.turn_taking.agent import TurnTaker, TurnTakerConfig
from jointattn_mj.baselines.turn_taking.attempts import AttemptSituations, run_attempts
from jointattn_mj.baselines.turn_taking.faces import (
    FACE_DIRECTION,
    FaceBank,
    FaceBankConfig,
    FaceInputs,
    gaze_deg,
    render_faces,
)
from jointattn_mj.baselines.turn_taking.layouts import ObjectTableConfig, draw_tables
from jointattn_mj.errors import ConfigError
from jointattn_mj.perception.state import StateConfig
from jointattn_mj.scene.camera import in_image, pixels_of_points

pytestmark = pytest.mark.integration

HEIGHT = 0.741  # of an object's centre, metres
SHORT = TurnTakerConfig(hidden=20, rate=0.004, gate_midpoint=4000.0, gate_width=1000.0)
TABLE_3, VIEW_3 = ObjectTableConfig(objects=3), ObjectTableConfig(objects=3, region="in_view")


def code_faces(seed: int = 0, count: int = 400) -> FaceInputs:
    """Made-up faces, a smooth code of the gaze in 20 numbers: for tests of everything but the images."""
    rng = np.random.default_rng(seed)
    gaze = np.column_stack([rng.uniform(-50, 50, count), rng.uniform(12, 32, count)])
    code = np.random.default_rng(99).standard_normal((2, 20)) / [[25], [6]]
    patterns = np.tanh((gaze - [0, 22]) @ code) * 2
    return FaceInputs(patterns.astype(np.float32), gaze, np.zeros(20), 1.0)


def situations(faces: FaceInputs, table: ObjectTableConfig, seed: int = 1, count: int = 800) -> AttemptSituations:
    rng = np.random.default_rng(seed)
    return AttemptSituations.of_locations(draw_tables(table, count, rng), faces, 0.0, rng)


def taker(config: TurnTakerConfig, faces: FaceInputs, seed: int = 2) -> TurnTaker:
    return TurnTaker(config, faces.patterns.shape[1], np.random.default_rng(seed))


def first_view(locations: np.ndarray) -> np.ndarray:
    points = np.concatenate([locations, np.full((*locations.shape[:-1], 1), HEIGHT)], axis=-1)
    return in_image(pixels_of_points(points.reshape(-1, 3), FACE_DIRECTION)).reshape(locations.shape[:-1])


@pytest.mark.parametrize(("region", "objects"), [("in_view", 10), ("table", 10), ("outside", 3)])
def test_tables_keep_objects_apart_and_in_their_region(region, objects):
    locations = draw_tables(ObjectTableConfig(objects=objects, region=region), 200, np.random.default_rng(0))
    assert locations.shape == (200, objects, 2)
    apart = np.linalg.norm(locations[:, :, None] - locations[:, None], axis=3) + 9 * np.eye(objects)
    assert apart.min() >= 0.13
    visible = first_view(locations).mean()
    assert {"in_view": visible > 0.99, "outside": visible == 0, "table": 0.5 < visible < 0.8}[region]
    assert (
        locations == draw_tables(ObjectTableConfig(objects=objects, region=region), 200, np.random.default_rng(0))
    ).all()


def test_a_table_too_full_is_named(monkeypatch):
    monkeypatch.setattr("jointattn_mj.baselines.turn_taking.layouts.TRIES", 5)
    with pytest.raises(ConfigError, match="no room for 40 objects"):
        draw_tables(ObjectTableConfig(objects=40, region="outside"), 2, np.random.default_rng(0))


def test_the_caregiver_turns_to_the_side_where_the_object_is():
    ahead, robots_left, near_robot = gaze_deg(np.array([[1.0, 0.0], [1.0, 0.3], [0.6, 0.0]]))
    assert ahead[0] == pytest.approx(0) and ahead[1] == pytest.approx(np.degrees(np.arctan2(1.08 - 0.741, 0.5)))
    assert robots_left[0] == pytest.approx(-np.degrees(np.arctan2(0.3, 0.5)))  # world +y is to her right
    assert near_robot[1] < ahead[1]


@pytest.fixture(scope="module")
def bank() -> FaceBank:
    return render_faces(FaceBankConfig(faces=120, familiar=60), np.random.default_rng(0))


def test_faces_are_rendered_detected_and_tell_where_the_caregiver_looks(bank):
    assert bank.patches.shape == (120, 1024) and bank.gaze.shape == (120, 2)  # none was missed
    inputs = bank.inputs(10.0)
    assert np.sqrt(np.square(inputs.patterns).sum(axis=1).mean()) == pytest.approx(10, rel=1e-4)
    assert inputs.patterns.mean(axis=0) == pytest.approx(0, abs=1e-4)
    ones = np.column_stack([inputs.patterns, np.ones(120)])
    even, odd = np.arange(0, 120, 2), np.arange(1, 120, 2)
    ridge = ones[even].T @ ones[even] + 30 * np.eye(1025)
    guess = ones[odd] @ np.linalg.solve(ridge, ones[even].T @ bank.gaze[even])
    assert np.median(np.abs(guess - bank.gaze[odd]), axis=0)[0] < 4
    assert bank.gaze[:, 0].std() > 15


def test_a_face_is_taken_by_the_direction_of_gaze():
    faces = code_faces()
    locations = np.array([[[1.0, 0.2], [0.6, -0.5]]])
    chosen = faces.of_locations(locations, 0.0, np.random.default_rng(0))
    assert chosen.shape == (1, 2)
    distance = np.linalg.norm(faces.gaze[chosen] - gaze_deg(locations), axis=-1)
    assert (distance == np.linalg.norm(faces.gaze - gaze_deg(locations)[:, :, None], axis=-1).min(axis=-1)).all()


def test_visual_feedback_reaches_some_object_and_the_caregivers_by_chance():
    faces = code_faces()
    robot = taker(replace(SHORT, gate="shut"), faces)
    outcomes = run_attempts(robot, situations(faces, VIEW_3), faces, 3000, np.random.default_rng(3))
    assert outcomes.reached.mean() > 0.99 and outcomes.in_view.mean() > 0.99
    assert outcomes.right.mean() == pytest.approx(1 / 3, abs=0.03)
    assert (outcomes.movements == SHORT.steps).all()


def test_visual_feedback_does_not_reach_what_was_never_in_view():
    faces = code_faces()
    robot = taker(replace(SHORT, gate="shut"), faces)
    outside = situations(faces, ObjectTableConfig(objects=3, region="outside"))
    outcomes = run_attempts(robot, outside, faces, 300, np.random.default_rng(3))
    assert not outcomes.reached.any() and not outcomes.in_view.any()


def test_any_object_then_the_caregivers_in_view_then_outside():
    faces = code_faces()
    quick = TurnTakerConfig(rate=0.006, first_face_weight=0.1, gate_midpoint=8000.0, gate_width=2500.0)
    robot = taker(quick, faces)
    table = situations(faces, TABLE_3)
    early, _, late = (
        run_attempts(robot, table, faces, count, np.random.default_rng(count)) for count in (2000, 60_000, 4000)
    )
    assert robot.time == 66_000
    assert early.reached.mean() > 0.9 and early.right.mean() == pytest.approx(1 / 3, abs=0.05)
    assert early.right[~early.in_view].mean() < 0.05
    assert late.right[late.in_view].mean() > 0.8
    assert 0.2 < late.right[~late.in_view].mean() < late.right[late.in_view].mean()  # .31 to .72 over five seeds


def test_learning_from_the_movement_made_drifts_away_from_objects():
    faces = code_faces()
    single = situations(faces, ObjectTableConfig(objects=1, region="in_view"))
    success = {}
    for reference in ("object", "executed"):
        robot = taker(replace(SHORT, reference=reference), faces)
        run_attempts(robot, single, faces, 20_000, np.random.default_rng(0))
        success[reference] = run_attempts(
            robot, single, faces, 1000, np.random.default_rng(1), learning=False
        ).right.mean()
    assert success["object"] > 0.9
    assert success["executed"] < 0.4


def test_a_failed_attempt_teaches_nothing_and_tests_change_nothing():
    faces = code_faces()
    robot = taker(replace(SHORT, gate="open", centre_radius_deg=1e-6), faces)
    before = [array.copy() for array in robot.network]
    table = situations(faces, TABLE_3)
    assert not run_attempts(robot, table, faces, 200, np.random.default_rng(0)).reached.any()
    assert robot.time == 200 and all((a == b).all() for a, b in zip(before, robot.network, strict=True))
    robot = taker(SHORT, faces)
    before = [array.copy() for array in robot.network]
    assert run_attempts(robot, table, faces, 200, np.random.default_rng(0), learning=False).reached.any()
    assert robot.time == 0 and all((a == b).all() for a, b in zip(before, robot.network, strict=True))


def test_same_seed_same_run_and_blind_eyes_reach_nothing():
    faces = code_faces()
    table = situations(faces, TABLE_3)
    first, again = (run_attempts(taker(SHORT, faces), table, faces, 500, np.random.default_rng(7)) for _ in range(2))
    assert (first.right == again.right).all() and (first.movements == again.movements).all()
    blind = run_attempts(
        taker(SHORT, faces), table, faces, 50, np.random.default_rng(7), senses=StateConfig(object_miss=1.0)
    )
    assert not blind.reached.any()


def test_ending_at_the_first_object_takes_fewer_steps():
    faces = code_faces()
    table = situations(faces, ObjectTableConfig(objects=5, region="in_view"))
    robot = taker(replace(SHORT, ends="first", gate="shut"), faces)
    outcomes = run_attempts(robot, table, faces, 300, np.random.default_rng(0))
    assert outcomes.reached.mean() > 0.99 and outcomes.movements.mean() < 3


def test_a_run_in_counts(monkeypatch, bank):
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2]))
    from experiments.turn_taking import analysis, sweep
    from jointattn_mj.sweeps.claim import Trial

    run = sweep.AttemptsConfig(TABLE_3, replace(SHORT, hidden=5), attempts=600, tables=50, tests=60)
    monkeypatch.setattr(sweep, "face_banks", lambda config: (bank, bank))
    result = sweep.trial(run, 4)
    assert result == sweep.trial(run, 4) != sweep.trial(run, 5)
    assert len(result["attempts"]) == sweep.BINS and sum(result["attempts"]) == 600
    visible, hidden = np.array(result["right_in_view"]), np.array(result["right_outside"])
    assert (visible + hidden == result["right"]).all()
    assert result["test_new_attempts"] == [60]
    cells = {name: [Trial(name, 4, result)] for name in ("objects_3", "objects_5", "in_view_5")}
    findings = analysis.analyse(cells)
    assert any("3 objects" in finding.what and finding.ours.n == 1 for finding in findings)
    assert list(analysis.draw(cells)) == ["turn_taking"]


def test_when_a_stage_is_reached(monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2]))
    from experiments.turn_taking.analysis import reaches

    rates = np.array([[0.0, 0.5, 1.0], [0.0, 0.1, 0.2], [0.8, 0.9, 1.0]])
    assert reaches(rates, 0.75).tolist() == [2.0, np.inf, 0.5]
