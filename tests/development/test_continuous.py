"""Gaze following in continuous space: which pairs count, and when the map takes over from the table."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from jointattn_mj.contingency.online.events import Event
from jointattn_mj.contingency.online.modules import ReproductionConfig, make_module
from jointattn_mj.development.config import DevelopmentOptions
from jointattn_mj.development.rendered.config import RenderedDevelopmentConfig
from jointattn_mj.development.rendered.continuous import (
    BACKWARD,
    FORWARD,
    SCATTERED,
    ContinuousConfig,
    ContinuousModule,
    ContinuousRun,
    Pair,
)
from jointattn_mj.development.run import run_development
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.development.table.world import TableConfig
from jointattn_mj.errors import ConfigError
from jointattn_mj.io import checkpoint

pytestmark = pytest.mark.integration

FOLLOWS = Event(0, 0, 2)
"""(S1, A1, R3)"""
TABLE = np.zeros((2, 2, 2, 2))
TABLE[0] = [[[4, 16], [20, 0]], [[20, 0], [4, 16]]]  # (S, A, R'): each face has its direction
INFORMATIVE = [(0, 0), (1, 1)]


def module(enough=3):
    made = make_module(FOLLOWS, TABLE, ReproductionConfig())
    return ContinuousModule(made, ContinuousConfig(enough=enough), 4, np.random.default_rng(0))


def test_what_led_to_the_result_beyond_chance_is_informative():
    made = module()
    for s in range(2):
        for a in range(2):
            assert made.is_informative(0, s, 1, a) == ((s, a) in INFORMATIVE)


def test_pairs_never_seen_are_not_informative():
    assert not module().is_informative(1, 0, 1, 0)


def test_a_map_is_ready_when_it_knows_enough_and_says_what_it_was_told():
    made, face, direction = module(enough=40), np.array([1.0, 0, 0, 0]), np.array([7.3, -14.1])
    for step in range(40):
        assert not made.ready
        made.learn(Pair(step, face, direction, FORWARD, True))
    assert made.ready
    assert made.learner.predict(face) == pytest.approx(direction, abs=0.5)


def test_wrong_options():
    with pytest.raises(ConfigError):
        ContinuousConfig(enough=0)


@pytest.fixture(scope="module")
def runs():
    """A life in which gaze following is found early, for it is given; and what it was before, pickled."""
    config = replace(SCATTERED, exploration=240)
    run = ContinuousRun(TableConfig(), config, PRESETS["fast"].agent, 3, 1300, ContinuousConfig(enough=15))
    run.advance(600)
    run.take_in(run.agent.events.index(FOLLOWS))
    before = pickle.dumps(run)
    run.advance(700)
    yield run, before
    run.close()


def test_the_map_learns_from_informative_pairs_and_then_moves_the_head(runs):
    run, _ = runs
    following = run.following
    assert following is not None and following.ready
    informative = [pair for pair in run.pairs if pair.informative]
    assert following.pairs == len(informative) > 15
    assert all(pair.step >= 600 and pair.order == FORWARD for pair in informative)
    assert {pair.order for pair in run.pairs} == {FORWARD, BACKWARD}
    by_map = [landing for landing in run.landings if landing.by_map]
    assert by_map and all(landing.step > informative[14].step for landing in by_map)
    assert not [landing for landing in run.landings if landing.step > by_map[0].step and not landing.by_map]


def test_interrupted_it_goes_on_the_same(runs):
    run, before = runs
    for n_steps in (130, 250, 320):
        other = pickle.loads(before)
        other.advance(n_steps)
        before = pickle.dumps(other)
        other.close()
    for column in run.columns:
        assert np.array_equal(run.log(column), other.log(column)), column
    assert run.landings == other.landings
    assert np.array_equal(run.following.learner.weights(), other.following.learner.weights())


def test_the_command_stops_and_goes_on_the_same(tmp_path):
    """Its options, its checkpoints and its summary."""
    config = RenderedDevelopmentConfig.of(
        maps="continuous", seed=3, steps=60, rendered={"exploration": 240}, continuous={"enough": 15}
    )
    assert config.rendered == replace(SCATTERED, exploration=240)
    whole = run_development(config, DevelopmentOptions(tmp_path / "whole"))
    assert whole.summary.more["landings"]["map"]["gaze_shifts"] == 0
    stopped = DevelopmentOptions(tmp_path / "stopped", checkpoint_every=20)

    def stop(run, found):
        if run.steps_done == 40:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_development(config, stopped, stop)
    assert run_development(config, replace(stopped, resume=True)) == whole


def test_a_checkpoint_holds_the_map(runs, tmp_path):
    run, _ = runs
    config = RenderedDevelopmentConfig.of(
        maps="continuous", seed=3, steps=1300, rendered={"exploration": 240}, continuous={"enough": 15}
    )
    checkpoint.save(tmp_path / "c", run, config)
    other = checkpoint.load(tmp_path / "c", config, kind=config.kind)
    assert np.array_equal(run.following.learner.weights(), other.following.learner.weights())
    for mine, its in zip(run.pairs, other.pairs, strict=True):
        assert (mine.step, mine.order, mine.informative) == (its.step, its.order, its.informative)
        assert np.array_equal(mine.activations, its.activations) and np.array_equal(mine.direction, its.direction)
    assert run.landings == other.landings
    assert run.more()["pairs_learned_from"] == run.following.pairs
    other.close()


def test_maps_and_resolution_do_not_go_together():
    with pytest.raises(ConfigError, match="maps discrete"):
        RenderedDevelopmentConfig.of(maps="continuous", resolution="growing")
