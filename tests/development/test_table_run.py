"""A run at a table: the log says what happened, and however it is interrupted, it goes on the same."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import jointattn_mj.contingency as c
from jointattn_mj.contingency.online.detector import DetectorConfig
from jointattn_mj.contingency.online.events import Event
from jointattn_mj.contingency.online.local import LocalConfig
from jointattn_mj.contingency.online.reactive import AvoidingModule
from jointattn_mj.development.agent import Developer, DeveloperConfig
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.development.table.run import TableRun
from jointattn_mj.development.table.world import CAREGIVER, OPTION, TableConfig, new_table, step, table_variables
from jointattn_mj.errors import ConfigError
from jointattn_mj.io import rows

pytestmark = pytest.mark.integration

HASTY = DeveloperConfig(detector=DetectorConfig(threshold=2e-3), most_modules=3)
"""Finds something every few hundred turns."""
WORLD = TableConfig()
AGENTS = {
    "whole": HASTY,
    "reset": replace(HASTY, memory="reset"),
    "window": replace(HASTY, memory="window", horizon=500),
    "fading": replace(HASTY, memory="fading", horizon=500),
    "full": replace(HASTY, history="full"),
    "refresh": replace(HASTY, refresh_every=150),
    "local": DeveloperConfig(
        detector=DetectorConfig(stop_rule="local"),
        local=LocalConfig(deviations=1.0, best=0.5, false_alarm=1.0, evidence_overall=1e-9),
        most_modules=3,
    ),
}
STEPS = 1200


def steps_done(agent=HASTY, n_steps=STEPS, seed=4, world=WORLD, reactive=(), **options):
    run = TableRun(world, agent, seed, n_steps, reactive, **options)
    run.advance(n_steps)
    return run


def same(run, other_run):
    assert run.steps_done == other_run.steps_done
    for column in run.columns:
        assert np.array_equal(run.log(column), other_run.log(column)), column
    assert [(f.step, f.event) for f in run.detections] == [(f.step, f.event) for f in other_run.detections]
    for first, second in zip(run.agent.modules, other_run.agent.modules, strict=True):
        assert np.array_equal(first.command, second.command)
        assert np.array_equal(first.reliability, second.reliability)
    assert all(
        np.array_equal(*pair, equal_nan=True) for pair in zip(run.contingency(), other_run.contingency(), strict=True)
    )
    assert np.array_equal(run.agent.state.counts.entries, other_run.agent.state.counts.entries)
    assert np.array_equal(run.agent.state.counts.sums, other_run.agent.state.counts.sums)


@pytest.fixture(scope="module", params=AGENTS)
def undisturbed(request):
    run = steps_done(AGENTS[request.param])
    assert run.detections, "else nothing grows in these tests"
    return run


def test_the_log_says_what_happened(undisturbed):
    """The same life once more in plain Python, through ``Developer.act``."""
    run = undisturbed
    of_world, of_agent = np.random.SeedSequence(4).spawn(2)
    table, agent = new_table(WORLD, of_world), Developer(table_variables(WORLD), run.agent.config, of_agent)
    s, r, a = np.zeros(2, np.int64), np.zeros(3, np.int64), np.zeros(2, np.int64)
    rows = []
    for _ in range(STEPS):
        step(table, a, s, r)
        before = len(agent.modules)
        a = agent.act(s, r)
        driver = agent.state.driver - (agent.state.driver >= before) * (
            len(agent.modules) - before
        )  # as numbered before
        rows.append([*s, *r, *a, *driver, table.state[CAREGIVER], table.state[OPTION]])
    for number, column in enumerate(run.columns):
        assert run.log(column).tolist() == [row[number] for row in rows], column
    assert [module.event for module in agent.modules] == [module.event for module in run.agent.modules]
    assert np.array_equal(agent.state.counts.entries, run.agent.state.counts.entries)


def test_the_same_seed_is_the_same_run(undisturbed):
    same(undisturbed, steps_done(undisturbed.agent.config))
    other = steps_done(undisturbed.agent.config, seed=5)
    assert not np.array_equal(undisturbed.log("gesture"), other.log("gesture"))


@settings(max_examples=6, deadline=None, derandomize=True)
@given(st.lists(st.integers(1, 400), min_size=1, max_size=6))
def test_interrupted_and_stored(undisturbed, pieces):
    run, found = TableRun(WORLD, undisturbed.agent.config, 4, STEPS), []
    for piece in [*pieces, STEPS]:
        found += run.advance(piece)
        run = pickle.loads(pickle.dumps(run))
    same(run, undisturbed)
    assert [detection.step for detection in found] == [detection.step for detection in undisturbed.detections]


@settings(max_examples=6, deadline=None, derandomize=True)
@given(st.lists(st.integers(1, 400), min_size=1, max_size=6))
def test_kept_in_a_folder(undisturbed, tmp_path_factory, pieces):
    """With small buffers; killed after every piece but some turns later, and resumed."""
    folder = tmp_path_factory.mktemp("log")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rows, "BUFFER_BYTES", 1000)
        run = TableRun(WORLD, undisturbed.agent.config, 4, STEPS)
        run.attach(folder)
        for piece in [*pieces, STEPS]:
            run.advance(piece)
            checkpoint = pickle.dumps(run)
            run.advance(300)
            run = pickle.loads(checkpoint)
            run.attach(folder)
            if piece == pieces[0]:
                kept = pickle.loads(checkpoint)
        same(run, undisturbed)
        kept.recall(folder)
        kept.advance(STEPS)
        same(kept, undisturbed)
        same(run, undisturbed)


def test_stopped_exactly_where_something_is_found(undisturbed):
    moment = undisturbed.detections[0].step
    for pause in (moment - 1, moment, moment + 1):
        run = TableRun(WORLD, undisturbed.agent.config, 4, STEPS)
        assert len(run.advance(pause)) == (pause >= moment)
        run = pickle.loads(pickle.dumps(run))
        run.advance(STEPS)
        same(run, undisturbed)


def test_it_ends():
    run = TableRun(WORLD, HASTY, 0, 50)
    run.advance(80)
    assert run.steps_done == 50
    assert run.advance(10) == []
    assert run.steps_done == 50
    assert len(run.log("shift gaze")) == 50


@pytest.mark.parametrize("correction", ["none", "miller_madow"])
def test_contingency_is_that_of_the_log(correction):
    run = steps_done(replace(HASTY, detector=replace(HASTY.detector, correction=correction)), sample_every=100)
    n_steps, values = run.contingency()
    variables = run.agent.variables
    assert n_steps.tolist() == list(range(100, STEPS + 1, 100))
    assert values.shape == (12, len(run.agent.events))
    first = table_variables(WORLD)
    for number, event in enumerate(first.events()):
        assert run.agent.events[number] == event
        known = variables.sensors[event.sensor], variables.actions[event.action]
        columns = [run.log(variable.name) for variable in known]
        columns.append(run.log(variables.results[event.result].name))
        for turn_, row in zip(n_steps, values, strict=True):
            expected = c.state_action_contingency(*(column[:turn_] for column in columns), correction=correction)
            assert row[number] == pytest.approx(expected, abs=1e-12)
    initial = [0] * 12 + [run.detections[0].step] * (len(run.agent.events) - 12)
    for number in range(len(list(first.with_module("module 1").events()))):
        assert np.isnan(values[:, number]).tolist() == (n_steps < initial[number]).tolist()


def test_samples_do_not_change_the_run():
    often, seldom = steps_done(sample_every=1), steps_done(sample_every=STEPS + 1)
    assert all(np.array_equal(often.log(column), seldom.log(column)) for column in often.columns)
    assert len(often.contingency()[0]) == STEPS
    assert len(seldom.contingency()[0]) == 0


def test_what_is_left_when_no_more_modules_are_made():
    run = steps_done(replace(HASTY, most_modules=1), n_steps=2000)
    assert [detection.module is None for detection in run.detections] == [False] + [True] * (len(run.detections) - 1)
    assert len(run.detections) > 1
    assert len({detection.event for detection in run.detections}) == len(run.detections)
    assert len(run.agent.modules) == 1
    nothing = steps_done(replace(HASTY, most_modules=0))
    assert nothing.agent.modules == []
    assert nothing.detections[0].module is None
    assert set(nothing.log("driver of shift gaze")) == {0}


def test_what_is_detected_without_a_module_is_found_once():
    run = steps_done(replace(AGENTS["local"], most_modules=1), n_steps=2000)
    assert [detection.module is None for detection in run.detections][:2] == [False, True]
    assert len({detection.event for detection in run.detections}) == len(run.detections)


def test_a_robot_that_avoids_faces():
    avoiding = steps_done(n_steps=1000, reactive=[AvoidingModule("shift gaze", "caregiver", share=0.0)])
    assert (avoiding.log("shift gaze") != 3).all()
    assert set(avoiding.log("gesture")) == {0, 1, 2, 3}


def test_following_the_gaze_is_found_first():
    """Section 5.3.2, one seed; how often is for the experiments."""
    preset = PRESETS["thesis"]
    run = TableRun(preset.world, preset.agent, 1, 10000)
    while not run.detections and run.steps_done < 10000:
        run.advance(1000)
    (found,) = run.detections
    assert found.event == Event(0, 0, 2)
    assert run.agent.variables.describe(found.event) == "caregiver's face, shift gaze -> object"
    for spot in range(3):
        assert found.module.command[0, spot] == spot
        assert found.module.expected[0, spot] == 1


@pytest.mark.parametrize("name", PRESETS)
def test_presets_live(name):
    preset = PRESETS[name]
    assert preset.why
    assert steps_done(preset.agent, n_steps=200, world=preset.world).steps_done == 200


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"seed": -1}, "-1"),
        ({"n_steps": 0}, "0"),
        ({"sample_every": 0}, "0"),
        ({"agent": replace(HASTY, most_modules=127)}, "129"),
    ],
)
def test_impossible_runs(arguments, word):
    with pytest.raises(ConfigError, match=word):
        TableRun(**({"world": WORLD, "agent": HASTY, "seed": 0, "n_steps": 10} | arguments))


class TestRestoredRuns:
    """Numbers that would let compiled code write beyond its arrays."""

    @staticmethod
    def made_up(**changes):
        run = steps_done(AGENTS["local"], n_steps=300)
        for name, value in changes.items():
            setattr(run.agent._looks if name == "next" else run, name, value)
        return pickle.dumps(run)

    @pytest.mark.parametrize("changes", [{"next": 10**6}, {"steps_done": 0}, {"steps_done": 301}])
    def test_steps_for_which_there_is_no_room(self, changes):
        with pytest.raises(ValueError, match=r"no room|are done"):
            pickle.loads(self.made_up(**changes))
        assert pickle.loads(self.made_up()).steps_done == 300
