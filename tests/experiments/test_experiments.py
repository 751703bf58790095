"""Every claim of the registry: it can be stored, its trials are told apart, and it reads what little there may be."""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

sys.path.append(str(Path(__file__).parents[2]))

from experiments.registry import REGISTRY
from experiments.sessions import sweep
from experiments.som.sweep import apart, explained, packed, unpacked
from jointattn_mj.sweeps.claim import Comparison, Trial, Verdict
from jointattn_mj.sweeps.store import Keys, text_of
from jointattn_mj.sweeps.worker import pack

CHAPTER_6 = {"6.6", "6.7", "6.8", "baselines"}


@pytest.mark.parametrize("claim_id", REGISTRY)
def test_a_claim_can_be_run_and_read(claim_id):
    claim = REGISTRY[claim_id]
    keys = Keys(claim)
    assert len({keys.key(name, 0) for name in claim.settings}) == len(claim.settings)
    for setting in claim.settings.values():
        assert json.loads(text_of(setting.config)) is not None
        assert pack(claim.trial, setting.config)
    assert claim.title and claim.source and claim.says.endswith(".")
    assert all(isinstance(finding, Comparison) for finding in claim.analyse({}))
    assert all(isinstance(figure, Figure) for figure in claim.draw({}).values())


def test_chapter_6_is_complete():
    assert set(REGISTRY) >= CHAPTER_6
    assert REGISTRY["6.8"].film.is_file()


def session(successes: int, late: float, pan_learns: float, tilt_learns: float, seed: int = 0) -> dict:
    """A made-up session of 25 minutes with ten shifts in each, whose pan and tilt errors vanish at these minutes."""
    rng = np.random.default_rng(seed)
    at = np.repeat(np.arange(25) * 60.0, 10) + np.tile(np.arange(10) * 6.0, 25)
    good = rng.random(250) < successes / 250
    return {
        "gaze_shifts": 300,
        "successes": successes,
        "successes_at_launch": successes,
        "successes_at_landing": successes,
        "landings_on_nothing": 10,
        "successes_on_something": successes,
        "late_rate": late,
        "map_error_deg": {"median": None, "n": 0},
        "shifts": {
            "landing_s": at.tolist(),
            "success": good.tolist(),
            "pan_error_deg": np.where(at < pan_learns * 60, 20.0, 0.5).tolist(),
            "tilt_error_deg": np.where(at < tilt_learns * 60, 20.0, 0.5).tolist(),
        },
    }


def test_sessions_are_held_against_the_published_means():
    claim = REGISTRY["6.8"]
    trials = {
        "state/cues": [Trial("state/cues", seed, session(195 + seed, 0.8, 8, 12)) for seed in range(6)],
        "state/no_cues": [Trial("state/no_cues", seed, session(80 + seed, 0.5, 12, 12)) for seed in range(6)],
        "state/cues_linear": [Trial("state/cues_linear", 0, session(100, 0.3, 12, 12))],
    }
    found = {finding.what: finding for finding in claim.analyse(trials)}
    assert found["successes, with motion cues, from the state"].verdict is Verdict.REPRODUCED
    assert found["successes, without motion cues, from the state"].verdict is Verdict.NOT
    difference = found["successes, with motion cues less without, from the state"]
    assert (difference.ours.mean, difference.verdict) == (115, Verdict.REPRODUCED)
    apart = found[
        "minutes by which half of the gain in tilt comes after half of that in pan, from the state, with motion cues"
    ]
    assert apart.ours.mean == pytest.approx(4, abs=1)
    assert found["successes, from the state, with motion cues, linear"].ours.n == 1
    assert set(claim.draw(trials)) == {"sessions", "pan_and_tilt"}


def test_one_session_decides_nothing():
    claim = REGISTRY["6.8"]
    single = {f"state/{name}": [Trial(name, 0, session(190, 0.8, 8, 8))] for name in ("cues", "no_cues")}
    found = {finding.what: finding for finding in claim.analyse(single)}
    assert found["successes, with motion cues less without, from the state"].verdict is Verdict.UNDECIDED


def test_a_session_says_what_it_did():
    config = sweep.SETTINGS["state/cues"].config
    robot = replace(config.robot, familiarise=replace(config.robot.familiarise, minutes=0.1))
    config = replace(config, minutes=1.0, robot=robot)
    result = sweep.trial(config, 3)
    assert text_of(result) == text_of(sweep.trial(config, 3))
    assert text_of(result) != text_of(sweep.trial(config, 4))
    assert len(result["shifts"]["success"]) == result["gaze_shifts"]
    assert "wall_seconds" not in result


def test_images_of_a_map_come_back():
    images = np.random.default_rng(0).random((3, 2, 4, 4))
    back = unpacked(packed(images), 3, 2)
    assert back.shape == (3, 2, 4, 4)
    assert np.corrcoef(back[1, 1].ravel(), images[1, 1].ravel())[0, 1] > 0.999
    assert apart(np.array([[0, 1], [0, 10], [0, 2], [0, 80]]), 9) == 0.5
    rows, columns = np.divmod(np.arange(81), 9)
    assert explained(rows, columns, 3.0 * rows - columns**2) == pytest.approx(1)
    assert explained(rows, columns, np.random.default_rng(1).random(81)) < 0.3
