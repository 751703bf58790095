"""Training PPO on ``follow``: a cell goes by its seed alone, all tests are of the same episodes, findings add up."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[2]))

from experiments.follow import sweep
from experiments.follow.analysis import steps_until
from experiments.registry import REGISTRY
from jointattn_mj.errors import ExtraError
from jointattn_mj.sweeps.claim import Trial, Verdict
from jointattn_mj.sweeps.store import text_of

pytestmark = pytest.mark.integration
SHORT = {"steps": 128, "every": 64, "copies": 2, "rollout": 32, "batch": 32, "epochs": 2, "episodes": 2}
CLAIM = REGISTRY["follow"]


@pytest.mark.parametrize("setting", ["follow/state", "follow/images"])
def test_a_cell_is_a_curve_and_the_same_again(setting):
    pytest.importorskip("stable_baselines3")
    config = replace(sweep.SETTINGS[setting].config, **SHORT)
    result = sweep.trial(config, 3)
    assert text_of(result) == text_of(sweep.trial(config, 3))
    assert result["steps"] == [0, 64, 128]
    assert len(result["reward"]) == 3
    assert all(0 <= reward <= 1 for reward in result["reward"])
    assert result["oracle"] > result["random"]


def test_another_seed_is_another_run():
    pytest.importorskip("stable_baselines3")
    untrained = replace(sweep.STATE, **SHORT | {"steps": 0})
    first, second = sweep.trial(untrained, 3), sweep.trial(untrained, 4)
    assert first["reward"] != second["reward"]
    assert first["random"] != second["random"]


def test_learners_and_baselines_are_tested_in_the_same_episodes():
    """The learner's likeliest action is put in its place by the oracle's: it earns what ``jointattn play`` says."""
    pytest.importorskip("stable_baselines3")
    from experiments.follow.training import _copies, earned, tested

    config = replace(sweep.STATE, **SHORT, truth=False)
    environment = _copies(config, 1)
    low, high = np.radians([-45.0, -35.0]), np.radians([45.0, 15.0])

    class Zero:
        def predict(self, observation, state=None, episode_start=None, deterministic=False):
            return (2 * (np.zeros((1, 2)) - low) / (high - low) - 1).astype(np.float32), None

    for seed in (1, 2):
        assert tested(Zero(), environment, seed, config.episodes) == pytest.approx(earned(config, "zero", seed))
    assert earned(config, "zero", 1) != earned(config, "zero", 2)
    environment.close()


def test_a_little_practice_is_enough_from_the_state():
    """Two thousand steps lead beyond whatever can be had without looking at her: some .67."""
    pytest.importorskip("stable_baselines3")
    result = sweep.trial(replace(sweep.STATE, steps=2048, every=2048, episodes=15), 1)
    assert result["reward"][-1] > 0.85 > result["reward"][0]


def test_the_patch_is_a_share_of_white():
    """A pixel that hardly changes must not be made as loud as one that tells the gaze."""
    pytest.importorskip("stable_baselines3")
    from experiments.follow.training import _copies

    config = replace(sweep.PATCH, **SHORT, patch_side=8)
    environment = _copies(config, 1)
    assert environment.observation_space["face_patch"].shape == (8, 8)
    environment.seed(0)
    patch = environment.reset()["face_patch"][0]
    assert environment.observation_space["face_patch"].contains(patch)
    assert 0.2 < patch.max() <= 1
    environment.close()


def run_of(setting: str, seed: int, rewards: list[float]) -> Trial:
    levels = {"oracle": 1.0, "random": 0.15, "zero": 0.3}
    return Trial(setting, seed, {"steps": [0, 1000, 2000], "reward": rewards, **levels})


def test_findings_tell_learning_from_what_can_be_had_blindfolded():
    trials = {
        "follow/state": [run_of("follow/state", seed, [0.6, 0.9, 0.99 - seed / 100]) for seed in range(4)],
        "follow/blindfolded": [run_of("follow/blindfolded", seed, [0.6, 0.6, 0.6]) for seed in range(4)],
    }
    found = {finding.what: finding for finding in CLAIM.analyse(trials)}
    assert {finding.verdict for finding in found.values()} == {Verdict.EXTENSION}
    earned = found["reward a step in follow after 2,000 steps, PPO from the state"].ours
    assert (earned.mean, earned.n) == (pytest.approx(0.975), 4)
    gain = found["the same less that of PPO blindfolded, follow, from the state"].ours
    assert gain.mean == pytest.approx(0.375)
    assert 0.3 < gain.low < gain.high < 0.4
    (until,) = [finding.ours for what, finding in found.items() if what.startswith("steps until 90%")]
    assert until.mean == 2000
    assert found["reward a step in follow, oracle"].ours.mean == 1.0
    assert steps_until(trials["follow/state"][0], 0.995) == np.inf
    assert set(CLAIM.draw(trials)) == {"follow"}


def test_one_learner_alone_can_be_read():
    trials = {"follow_hard/state": [run_of("follow_hard/state", 0, [0.0, 0.2, 0.4])]}
    assert not any("less that" in finding.what for finding in CLAIM.analyse(trials))
    assert set(CLAIM.draw(trials)) == {"follow"}


def test_without_stable_baselines_it_asks_for_it_by_name(monkeypatch):
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    monkeypatch.delitem(sys.modules, "experiments.follow.training", raising=False)
    with pytest.raises(ExtraError, match=r"pip install 'jointattn-mj\[rl\]'"):
        sweep.trial(sweep.STATE, 0)
