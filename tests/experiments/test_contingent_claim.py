"""The experiment on the cross-situational learner: its caregivers, its robot that watches, its analysis."""

from dataclasses import replace

import numpy as np
import pytest

from experiments.cross_situational import analysis, sweep
from experiments.cross_situational.caregivers import world_with
from experiments.registry import REGISTRY
from jointattn_mj.scene.caregiver import Phase
from jointattn_mj.scene.world import World, WorldConfig
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
    found = {one.what: one for one in REGISTRY["contingent"].analyse(trials)}
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


def test_strangers_are_told_apart():
    name = "strangers/three_teachers"
    shifts = {column: [True, False, True] for column in sweep.COLUMNS} | {"landing_s": [10.0, 100.0, 310.0]}
    people = sweep.SETTINGS[name].config.strangers
    trial = Trial(name, 0, dict.fromkeys(people, shifts))
    at_once, later = analysis.strangers([trial], "three teachers")
    assert at_once.what.startswith("rate with 3 strangers at once") and at_once.ours.mean == 1
    assert later.ours.mean == 1 and people[0] in later.note
