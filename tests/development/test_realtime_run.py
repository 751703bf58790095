"""Lives in real time: mostly with perception taken from the state, one from images."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from jointattn_mj.development.meaning import FACE, GAZE, OBJECT
from jointattn_mj.development.realtime.run import FRAMES_PER_MINUTE, RealtimeConfig, RealtimeRun
from jointattn_mj.development.rendered.observer import OBJECT_THERE
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.development.table.world import TableConfig
from jointattn_mj.errors import ConfigError

pytestmark = pytest.mark.integration

STATE = RealtimeConfig(perception="state", familiarise_minutes=1.0)
FAST = PRESETS["fast"]


def new_run(config: RealtimeConfig = STATE, seed: int = 3, table: TableConfig = FAST.world) -> RealtimeRun:
    return RealtimeRun(table, config, FAST.agent, seed, 4000, sample_every=50)


def same(run: RealtimeRun, other_run: RealtimeRun) -> None:
    for column in run.columns:
        np.testing.assert_array_equal(run.log(column), other_run.log(column), err_msg=column)
    np.testing.assert_array_equal(run.ended, other_run.ended)
    np.testing.assert_array_equal(run.contingency()[1], other_run.contingency()[1])
    assert [detection.step for detection in run.detections] == [detection.step for detection in other_run.detections]


@pytest.fixture(scope="module")
def steps_done() -> RealtimeRun:
    run = new_run()
    run.run_until(6.0)
    return run


def test_a_step_is_over_when_attention_has_had_enough(steps_done):
    assert 6.0 <= steps_done.minutes < 6.1
    frames = np.diff(steps_done.ended)
    assert (frames > 0).all() and steps_done.ended[-1] == steps_done.frame
    stayed = steps_done.log(GAZE)[:-2] == steps_done.log(GAZE)[1:-1]
    period, shift = STATE.attention.selection_period, STATE.shift_frames
    assert (frames[1:][stayed] % period == 0).all()  # no head turn: draws alone end it
    assert (frames[1:][~stayed] >= period + shift).all()
    longest = STATE.longest_s * 30
    assert frames.max() <= longest + 2 * shift


def test_what_it_senses_is_what_there_is(steps_done):
    counts = steps_done.confusion()[:-1, : steps_done.spots + 1]
    assert counts.max(axis=1).sum() > 0.93 * counts.sum()
    assert np.mean(steps_done.log(OBJECT) == steps_done.log(OBJECT_THERE)) > 0.98
    gaze = np.concatenate([[steps_done.spots], steps_done.log(GAZE)[:-1]])
    assert np.array_equal(steps_done.log(FACE) < len(counts), gaze == steps_done.spots)


def test_it_is_said_for_people_what_categories_of_faces_mean(steps_done):
    names = {name.split(" (")[0] for name in steps_done.named_variables().sensors[0].values}
    assert {"at spot 1", "at spot 2", "at spot 3", "at robot", "not seen"} <= names
    assert steps_done.more()["minutes"] == steps_done.frame / FRAMES_PER_MINUTE
    assert steps_done.minutes_at(steps_done.steps_done) == steps_done.minutes


def test_motion_cues_make_another_run_of_the_same_seed():
    quick = replace(STATE.attention, motion_delay=2.0)  # at once: what moves in fixations of 0.3 s moves for few frames
    runs = [new_run(replace(STATE, attention=attention)) for attention in (quick, replace(quick, motion_cues=False))]
    for run in runs:
        run.run_until(1.0)
    assert not np.array_equal(runs[0].ended, runs[1].ended)


def test_a_stored_run_goes_on_to_the_same_end(steps_done):
    whole, stored = new_run(), new_run()
    for steps in (1, 36, 100):
        stored.advance(steps)
        stored = pickle.loads(pickle.dumps(stored))
    whole.advance(137)
    same(whole, stored)


def test_another_number_of_places():
    run = new_run(table=TableConfig(spots=4, objects=3))
    run.run_until(1.0)
    assert run.heads.shape == (5, 2)
    assert set(run.log(GAZE)) == set(range(5))


def test_a_run_from_images_goes_on_from_a_pickle():
    config = RealtimeConfig(familiarise_minutes=0.4)
    whole = new_run(config, seed=5)
    stored: RealtimeRun = pickle.loads(pickle.dumps(whole))
    whole.advance(24)
    stored.advance(11)
    stored = pickle.loads(pickle.dumps(stored))
    stored.advance(13)
    same(whole, stored)
    assert np.mean(whole.log(OBJECT) == whole.log(OBJECT_THERE)) > 0.9
    gaze = np.concatenate([[whole.spots], whole.log(GAZE)[:-1]])
    assert np.array_equal(whole.log(FACE) < whole.senses.categories.count, gaze == whole.spots)
    whole.close()
    stored.close()


@pytest.mark.parametrize(
    "wrong", [{"perception": "guess"}, {"looks_every": 0}, {"longest_s": 0.0}, {"variation": "of everything"}]
)
def test_what_cannot_be_is_refused(wrong):
    with pytest.raises(ConfigError):
        RealtimeConfig(**wrong)


def test_a_table_that_the_scene_does_not_know_is_refused():
    with pytest.raises(ConfigError, match="objects"):
        new_run(table=TableConfig(spots=12, objects=11))
