"""The experiment on the cross-situational learner: its caregivers, its robot that watches, its analysis."""

from dataclasses import replace

import numpy as np
import pytest

from experiments.cross_situational import analysis, sweep
from experiments.cross_situational.caregivers import PLANE_X, world_with
from experiments.cross_situational.told import EXACT, PARTS, PartlyTold
from experiments.registry import REGISTRY
from jointattn_mj.errors import ConfigError
from jointattn_mj.perception.percept import Percept
from jointattn_mj.perception.state import StatePerception
from jointattn_mj.scene.camera import directions_to
from jointattn_mj.scene.caregiver import Phase
from jointattn_mj.scene.world import World, WorldConfig, WorldObservation
from jointattn_mj.sweeps.claim import Trial

pytestmark = pytest.mark.integration


def frames(seconds: float, **caregiver) -> list:
    """Phase, target, object in hand and gaze of the caregiver, (yaw, pitch) in degrees, frame by frame."""
    kind = world_with(**{"looks_away": 0.0, "looks_at_others": False, "handled": None} | caregiver)
    world = kind.build(WorldConfig(), np.random.SeedSequence(5))
    noted = []
    for _ in range(round(seconds * 30)):
        world.step(np.zeros(2))
        script = world.caregiver
        noted.append((script.phase, script.target, script.held, np.degrees(script._gaze).copy()))
    world.close()
    return noted


def test_a_caregiver_who_looks_as_usual():
    assert world_with(0.0, False, None) is World


def test_a_caregiver_who_looks_away():
    """Now and then at no object, and at the handled one else; the gaze never jumps."""
    noted = frames(120, looks_away=0.5)
    later = [target for phase, target, _, _ in noted if phase not in (Phase.GREET, Phase.TURN)]
    assert 0.3 < np.mean([target is None for target in later]) < 0.7
    assert all(target == held for _, target, held, _ in noted if None not in (target, held))
    assert np.abs(np.diff([gaze for *_, gaze in noted], axis=0)).max() < 8  # degrees a frame


def test_a_caregiver_who_looks_at_others():
    noted = frames(60, looks_at_others=True)
    looked = [(target, held) for _, target, held, _ in noted if held is not None]
    assert looked and all(target is not None and target != held for target, held in looked)


def test_distractors_are_never_handled():
    assert {held for _, _, held, _ in frames(90, handled=2)} == {None, 0, 1}


@pytest.mark.parametrize(
    ("kind", "options"), [(sweep.Upright, {"looks_away": 0.5}), (sweep.PartlyVisible, {"told": "motion"})]
)
def test_conditions_that_contradict_each_other(kind, options):
    with pytest.raises(ConfigError, match=r"handles all|needs perception pixels; got state"):
        sweep.condition(kind=kind, **options)


def test_objects_in_an_upright_square():
    """Moved from place to place within it, as wide as high for the robot, never below the table or before the face."""
    asked = sweep.SETTINGS["upright/state_no_cues"].config
    session = sweep.ConditionRun(asked, 1)
    places = []
    for _ in range(1200):
        session.world.step(np.zeros(2))
        if session.world.caregiver.held is None:
            places.append(session.world.caregiver.objects.copy())
    session.close()
    layout, (x, y, z) = asked.config.world.layout, np.vstack(places).T
    assert (x == PLANE_X).all()
    for along, span in ((z, layout.x_range), (y, layout.y_range)):
        assert span[0] <= along.min() < along.max() <= span[1] and len(np.unique(along)) > 5
    corners = [(PLANE_X, side, height) for side in layout.y_range for height in layout.x_range]
    spread = np.ptp(directions_to(np.array(corners)), axis=0)
    assert spread[0] == pytest.approx(spread[1], rel=0.05)


@pytest.mark.parametrize("part", PARTS)
def test_a_percept_of_which_a_part_is_told(part):
    """Each part comes from where it should; images here find no face, and objects elsewhere."""
    world = World.build(WorldConfig(), np.random.SeedSequence(5))
    for _ in range(50):  # until the head turns
        world.step(np.zeros(2))
    seen = Blind()
    told, exact = PartlyTold(seen, world, part), StatePerception(EXACT, world, np.random.default_rng(0))
    percept, true = (perception.perceive(WorldObservation(world), False) for perception in (told, exact))
    positions, pattern = part in ("positions", "all"), part in ("face_pattern", "all")
    assert percept.visible[:-1].all() and percept.visible[-1] == (positions and pattern)
    np.testing.assert_allclose(percept.px[0], true.px[0] if positions else (1, 2))
    np.testing.assert_array_equal(percept.moves, true.moves & percept.visible if part in ("motion", "all") else False)
    assert told.pattern_size == len(told.face_pattern()) == (2 if pattern else 3)
    world.close()


class Blind:
    """Perception from images that finds no face, and every object in one place."""

    pattern_size = 3

    def perceive(self, observation, landed: bool) -> Percept:
        visible = np.array([True] * 4 + [False])
        return Percept(visible, np.where(visible[:, None], (1.0, 2.0), np.nan), np.zeros(5, bool))

    def face_pattern(self) -> np.ndarray:
        return np.zeros(3)


def test_a_robot_that_watches_does_not_shift_its_gaze():
    """Before the test it learns; in the test it shifts, and learns nothing."""
    asked = sweep.SETTINGS["watching"].config
    brief = replace(asked.config.robot.familiarise, minutes=0.1)
    robot = replace(asked.config.robot, familiarise=brief)
    asked = replace(asked, config=replace(asked.config, minutes=sweep.TEST_MINUTES + 0.5, robot=robot))
    session = sweep.ConditionRun(asked, 1)
    session.begin()
    for _ in range(900):
        session.step()
    assert len(session.shifts) == 0
    learned = session.robot.learner.weights()
    assert learned[-1, -1] > 8
    for _ in range(900):
        session.step()
    session.close()
    assert len(session.shifts) > 5
    np.testing.assert_array_equal(session.robot.learner.weights(), learned)


def made_up(setting: str, seed: int, learned_at: float) -> Trial:
    """Ten shifts a minute: one in four right before a minute, nearly all after it."""
    at = np.arange(0, 26 * 60, 6.0)
    rng = np.random.default_rng(seed)
    good = rng.random(len(at)) < np.where(at < learned_at * 60, 0.25, 0.97)
    shifts = {name: good.tolist() for name in sweep.COLUMNS} | {"landing_s": at.tolist()}
    return Trial(setting, seed, {"successes": int(good.sum()), "map_error_deg": 7.0 if seed else 1.0, "shifts": shifts})


def test_what_is_found():
    trials = {
        name: [made_up(name, seed, minute) for seed in range(5)]
        for name, minute in {"state/no_cues": 4.0, "state/no_cues_thesis": 30.0}.items()
    }
    found = {finding.what: finding for finding in REGISTRY["contingent"].analyse(trials)}
    soon = found["minutes until a rate of 0.75, cross-situational, without motion cues, from the state"]
    assert soon.ours.mean == pytest.approx(4.5, abs=0.6)
    never = found["minutes until a rate of 0.6, the dissertation's rule, without motion cues, from the state"]
    assert never.ours is None and "never" in never.note
    late = found["late rate, cross-situational, without motion cues, from the state"]
    assert late.ours.mean == pytest.approx(0.97, abs=0.02)
    wrong = found["sessions with a map off by more than 6 deg, cross-situational, without motion cues, from the state"]
    assert wrong.ours.mean == 0.8
    figures = REGISTRY["contingent"].draw(trials | {"ablation/reached": [made_up("ablation/reached", 0, 9)]})
    assert set(figures) == {"cross_situational", "cross_situational_ablation"}


def test_the_axes_apart():
    """Pan right from the third minute, tilt from the eighth."""
    at = np.arange(0, 26 * 60, 6.0)
    off = {axis: np.where(at < 60 * minute, 9.0, 1.0).tolist() for axis, minute in (("pan", 3), ("tilt", 8))}
    name = "upright/pixels_no_cues"
    trials = [made_up(name, seed, 5.0) for seed in range(3)]
    for trial in trials:
        trial.result["shifts"] |= {f"{axis}_error_deg": errors for axis, errors in off.items()}
    near, apart = analysis.axes(trials, "objects")
    assert near.what.startswith("landings within 3.5 deg") and near.ours.mean == pytest.approx(0.5, abs=0.1)
    assert apart.ours.mean == pytest.approx(3.5, abs=1)
    assert "cross_situational_axes" in REGISTRY["contingent"].draw({name: trials})


def test_what_images_cost():
    names = ("state/no_cues", "pixels/no_cues", "faces/of_the_thesis", "told/motion")
    trials = {name: [made_up(name, seed, 4.0) for seed in range(2)] for name in names}
    for name in names:
        for trial in trials[name]:
            trial.result["shifts"]["phase_at_launch"] = ["put", "gaze"] * 130
    found = {finding.what: finding for finding in REGISTRY["contingent"].analyse(trials)}
    assert "late rate by the caregiver's task at launch, cross-situational, without motion cues, from images" in found
    assert any("motion told by the state" in what and ", less " in what for what in found)
    assert "cross_situational_images" in REGISTRY["contingent"].draw(trials)


def test_strangers_are_told_apart():
    name = "strangers/three_teachers"
    shifts = {column: [True, False, True] for column in sweep.COLUMNS} | {"landing_s": [10.0, 100.0, 310.0]}
    people = sweep.SETTINGS[name].config.strangers
    trial = Trial(name, 0, dict.fromkeys(people, shifts))
    at_once, later = analysis.strangers([trial], "three teachers")
    assert at_once.what.startswith("rate with 3 strangers at once") and at_once.ours.mean == 1
    assert later.ours.mean == 1 and people[0] in later.note
