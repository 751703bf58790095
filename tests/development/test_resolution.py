"""Values that split where contingency rises: partitions stay partitions, gains are what they claim."""

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import jointattn_mj.contingency as c
from jointattn_mj.contingency.online.resolution import (
    NOTHING_SENSED,
    Growth,
    Resolution,
    ResolutionConfig,
    branches,
    coarse,
    contingency,
    local_contingency,
    refined,
    splits,
    transitions,
)
from jointattn_mj.development.config import DevelopmentOptions
from jointattn_mj.development.meaning import FACE, OBJECT
from jointattn_mj.development.rendered.config import RenderedDevelopmentConfig
from jointattn_mj.development.rendered.growing import Babbling, GrowingConfig, GrowingRun, RecallingBody
from jointattn_mj.development.run import run_development
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.development.table.world import TableConfig
from jointattn_mj.errors import CheckpointError, ConfigError, SeriesError
from jointattn_mj.io import checkpoint

pytestmark = pytest.mark.integration

SPACE = np.array([[-20.0, 20.0], [-15.0, -14.0]])
PROTOTYPES = 12


def noise(n_steps, seed):
    """Sensations, commands and results that have nothing to do with each other."""
    rng = np.random.default_rng(seed)
    units = rng.integers(-1, PROTOTYPES, n_steps)
    commands = np.column_stack([rng.uniform(*axis, n_steps) for axis in SPACE])
    commands[rng.random(n_steps) < 0.4] = np.nan
    return units, commands, rng.integers(0, 2, n_steps)


def two_sides(n_steps, seed):
    """Low units tell of something on the left, high ones on the right; the rest of nothing."""
    units, commands, results = noise(n_steps, seed)
    left = units < PROTOTYPES // 2
    right_way = (commands[:, 0] < 0) == left
    known = (units != NOTHING_SENSED) & ~np.isnan(commands[:, 0])
    results[1:] = np.where(known, right_way, False)[:-1]
    return units, commands, results


def points(seed=0):
    return np.random.default_rng(seed).normal(size=(PROTOTYPES, 3))


def ordered():
    """In a row, with a gap in the middle."""
    return np.arange(PROTOTYPES, dtype=float)[:, None] + 20 * (np.arange(PROTOTYPES) >= PROTOTYPES // 2)[:, None]


@given(st.integers(0, 50), st.sampled_from(["average", "complete", "single", "ward"]))
@settings(max_examples=20, deadline=None)
def test_branches_are_nested_or_apart(seed, method):
    groups = branches(points(seed), method)
    assert len(groups) == len(set(groups)) == 2 * PROTOTYPES - 2
    assert all(group <= other or other <= group or not group & other for group in groups for other in groups)


@given(st.integers(0, 10_000), st.lists(st.integers(0, 10_000), max_size=4))
@settings(max_examples=20, deadline=None)
def test_a_refined_resolution_is_a_partition_and_its_gain_is_what_was_said(seed, picks):
    given_ = transitions(*noise(400, seed))
    resolution, tree = coarse(PROTOTYPES, SPACE), branches(points(), "average")
    for pick in picks:
        offers = list(splits(given_, resolution, tree, 5))
        split = offers[pick % len(offers)]
        finer = refined(resolution, split)
        assert contingency(given_, finer) - contingency(given_, resolution) == pytest.approx(split.gain, abs=1e-12)
        coarse_s, fine_s = resolution.sensor(given_.units), finer.sensor(given_.units)
        assert len({*zip(coarse_s, fine_s, strict=True)}) == len({*fine_s}) <= len(finer.sensed) + 1
        coarse_a, fine_a = resolution.action(given_.commands), finer.action(given_.commands)
        assert len({*zip(coarse_a, fine_a, strict=True)}) == len({*fine_a}) <= len(finer.boxes) + 1
        resolution = finer
    assert sorted(cell for leaf in resolution.sensed for cell in leaf) == list(range(PROTOTYPES))
    unsensed, unaimed = given_.units == NOTHING_SENSED, np.isnan(given_.commands[:, 0])
    assert ((resolution.sensor(given_.units) == len(resolution.sensed)) == unsensed).all()
    assert ((resolution.action(given_.commands) == len(resolution.boxes)) == unaimed).all()


@given(st.integers(0, 10_000))
@settings(max_examples=10, deadline=None)
def test_contingency_is_that_of_the_measures(seed):
    units, commands, results = two_sides(300, seed)
    given_, resolution = transitions(units, commands, results), coarse(PROTOTYPES, SPACE)
    resolution = refined(resolution, list(splits(given_, resolution, branches(ordered(), "ward"), 3))[-1])
    series = resolution.sensor(units), resolution.action(commands), results
    corrected = c.state_action_contingency(*series, base=np.e, correction="miller_madow")
    assert contingency(given_, resolution) == pytest.approx(corrected)
    plain = c.pointwise_state_action_contingency(*series, base=np.e)
    assert local_contingency(given_, resolution) == pytest.approx(plain)


def test_both_split_together_where_neither_says_anything_alone():
    given_ = transitions(*two_sides(3000, 1))
    growth = Growth(ordered(), SPACE)
    steps = growth.update(given_)
    assert steps[0].split.kind == "S and A"
    assert steps[0].split.axis == 0 and abs(steps[0].split.at) < 4
    assert len(growth.resolution.sensed) == 2
    assert set(growth.resolution.sensed) == {frozenset(range(6)), frozenset(range(6, 12))}
    assert steps[0].split.gain > 4 * steps[0].split.error


@pytest.mark.parametrize("seed", range(3))
def test_noise_splits_nothing(seed):
    growth = Growth(points(), SPACE)
    assert growth.update(transitions(*noise(6000, seed))) == []
    assert len(growth.resolution.sensed) == len(growth.resolution.boxes) == 1


def test_it_looks_again_only_when_there_is_enough_that_is_new():
    growth = Growth(ordered(), SPACE, ResolutionConfig(warm_up=100, look_again=0.5))
    given_ = transitions(*two_sides(3001, 2))
    assert growth.update(given_.some(slice(99))) == [] and growth.due(100)
    growth.update(given_.some(slice(1000)))
    assert not growth.due(1500) and growth.due(1501)


@pytest.mark.parametrize(
    "wrong", [{"linkage": "nearest"}, {"deviations": -1.0}, {"look_again": 0.0}, {"cuts": 0}, {"warm_up": 0}]
)
def test_wrong_options(wrong):
    with pytest.raises(ConfigError):
        ResolutionConfig(**wrong)


def test_series_of_unequal_length():
    units, commands, results = noise(50, 0)
    with pytest.raises(SeriesError):
        transitions(units[1:], commands, results)


def refuses_other_values(run: GrowingRun, config: GrowingConfig, path: Path) -> None:
    """A checkpoint with values that babbling cannot have found."""
    (first, *rest), boxes = run.resolution.sensed, run.resolution.boxes
    forged = {
        "resolution": [
            Resolution((first | {10**6}, *rest), boxes),  # a table of so many units would be made in every step
            Resolution((frozenset(), *rest), boxes),
            Resolution((*run.resolution.sensed, frozenset()), boxes),
            Resolution(run.resolution.sensed, (*boxes, boxes[0])),
        ],
        "frontal": [run.frontal[:-1], run.frontal.astype(int)],
        "directions": [run.directions[:-1], np.full_like(run.directions, np.nan)],
    }
    for name, values in forged.items():
        right = getattr(run, name)
        for value in values:
            setattr(run, name, value)
            checkpoint.save(path, run, config)
            with pytest.raises(CheckpointError, match=r"faces must share|must be \(|values that it cannot"):
                checkpoint.load(path, config, kind=GrowingRun)
        setattr(run, name, right)


def test_checkpoints_hold_a_robot_that_babbles_and_its_run(tmp_path, monkeypatch):
    monkeypatch.setattr(RecallingBody, "pages", 3)
    config = GrowingConfig(calibration=3, exploration=60, resolution=ResolutionConfig(warm_up=100, deviations=2.0))
    babbling = Babbling(TableConfig(spots=2, objects=1), config, 1, RecallingBody)
    babbling.advance(1000)
    checkpoint.save(tmp_path / "babbling.bin", babbling, config)
    other = checkpoint.load(tmp_path / "babbling.bin", config, kind=Babbling)
    for each in (babbling, other):
        each.advance(100)
    assert other.looked_at == babbling.looked_at
    run = GrowingRun(babbling, PRESETS["fast"].agent, 1, 200)
    run.advance(50)
    checkpoint.save(tmp_path / "run.bin", run, config)
    again = checkpoint.load(tmp_path / "run.bin", config, kind=GrowingRun)
    refuses_other_values(run, config, tmp_path / "forged.bin")
    for each in (run, again):
        each.advance(150)
        each.check()
        each.close()
    assert all(np.array_equal(run.log(column), again.log(column)) for column in run.columns)
    assert repr(run) == repr(again) == "GrowingRun(200 of 200 steps, 12 events, 0 modules)"


def test_babbling_and_its_run_go_on_the_same_after_a_pickle(monkeypatch):
    monkeypatch.setattr(RecallingBody, "pages", 6)
    config = GrowingConfig(calibration=3, exploration=80, resolution=ResolutionConfig(warm_up=1000))
    babbling = Babbling(TableConfig(spots=2, objects=1), config, 5, RecallingBody)
    babbling.advance(1500)
    other = pickle.loads(pickle.dumps(babbling))
    for each in (babbling, other):
        each.advance(3500)
    assert babbling.looked_at == other.looked_at
    for mine, its in zip(babbling.experience(), other.experience(), strict=True):
        assert np.array_equal(mine, its, equal_nan=True)
    assert [step.split for step in babbling.growth.steps] == [step.split for step in other.growth.steps]
    assert {babbling.body.nearest(direction) for direction in babbling.commands()} == {0, 1}, "a region to either side"
    runs = [GrowingRun(each, PRESETS["fast"].agent, 3, 400) for each in (babbling, other)]
    for run in runs:
        run.advance(400)
    for column in runs[0].columns:
        assert np.array_equal(runs[0].log(column), runs[1].log(column)), column
    assert (runs[0].log(FACE)[runs[0].faces() < 2] < len(babbling.growth.resolution.sensed)).all()
    assert runs[0].log(OBJECT).any()
    for each in (babbling, other):
        each.body.stage.world.close()


def test_the_command_babbles_stops_and_goes_on_the_same(tmp_path, monkeypatch):
    """Its options, its checkpoints and its summary."""
    monkeypatch.setattr(RecallingBody, "pages", 6)
    config = RenderedDevelopmentConfig.of(
        resolution="growing", seed=5, steps=60, table={"spots": 2, "objects": 1},
        rendered={"calibration": 3, "exploration": 80},
        babbling={"steps": 5000, "images": False, "resolution": {"warm_up": 1000}},
    )  # fmt: skip
    assert config.rendered.senses == GrowingConfig().senses
    whole = run_development(config, DevelopmentOptions(tmp_path / "whole"))
    with pytest.raises(ConfigError, match="filmed"):
        run_development(config, DevelopmentOptions(tmp_path / "film", video=True))
    more = whole.summary.more
    assert more["faces_told_apart"] > 1 and len(more["regions_of_gaze_deg"]) > 1 and more["splits"]
    stopped = DevelopmentOptions(tmp_path / "stopped", checkpoint_every=20)

    def stop(run, found):
        if run.steps_done == 40:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_development(config, stopped, stop)
    assert run_development(config, replace(stopped, resume=True)) == whole


def test_the_command_films_what_is_rendered(tmp_path):
    config = RenderedDevelopmentConfig.of(
        resolution="growing", seed=5, steps=12, table={"spots": 2, "objects": 1},
        rendered={"calibration": 3, "exploration": 80}, babbling={"steps": 50},
    )  # fmt: skip
    run_development(config, DevelopmentOptions(tmp_path, video=True))
    assert (tmp_path / "video.mp4").stat().st_size > 10_000
