"""A run from images: the agent is that of the symbolic table, and its sensors read what its camera shows."""

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest

from jointattn_mj.contingency.online.detector import DetectorConfig
from jointattn_mj.development import run as development
from jointattn_mj.development.agent import DeveloperConfig
from jointattn_mj.development.config import DevelopmentOptions, config_class
from jointattn_mj.development.rendered.body import Body
from jointattn_mj.development.rendered.config import RenderedDevelopmentConfig
from jointattn_mj.development.rendered.run import RenderedConfig, RenderedRun
from jointattn_mj.development.rendered.senses import PARTS, SensesConfig, alike, named_by_majority
from jointattn_mj.development.rendered.stage import StageConfig
from jointattn_mj.development.run import run_development
from jointattn_mj.development.table.config import TableDevelopmentConfig
from jointattn_mj.development.table.run import TableRun
from jointattn_mj.development.table.world import TableConfig, table_variables
from jointattn_mj.errors import ConfigError, ObservationError
from jointattn_mj.io import rows
from jointattn_mj.perception.faces import NO_FACE
from jointattn_mj.perception.percept import Percept
from jointattn_mj.scene.world import WorldConfig

pytestmark = pytest.mark.integration

HASTY = DeveloperConfig(detector=DetectorConfig(threshold=5e-3), most_modules=2)
SHORT = RenderedConfig(exploration=240)
CENTRE = replace(SHORT, draws="centre")
PLAIN = replace(SHORT, stage=StageConfig(variation="none"))
TRUE = replace(SHORT, senses=SensesConfig(state=PARTS))
TABLE = TableConfig()


def steps_done(config, n_steps, seed=2, agent=HASTY, stops=()):
    run = RenderedRun(TABLE, config, agent, seed, n_steps)
    for stop in (*stops, n_steps):
        run.advance(stop - run.steps_done)
    return run


@pytest.fixture(scope="module")
def run():
    return steps_done(SHORT, 400)


@pytest.fixture(scope="module", params=["all", "centre"])
def drawn(request, run):
    """Runs that see whole images, or what is at their centre."""
    return run if request.param == "all" else steps_done(CENTRE, 400)


def assert_same(run, other_run):
    assert run.steps_done == other_run.steps_done
    for column in run.columns:
        np.testing.assert_array_equal(run.log(column), other_run.log(column), err_msg=column)
    assert [(detection.step, detection.event) for detection in run.detections] == [
        (detection.step, detection.event) for detection in other_run.detections
    ]


def test_with_the_state_it_is_the_run_at_the_symbolic_table():
    """The agent is the same, and so is the table; only perception lies between them."""
    n_steps = 1500
    visible, symbolic = steps_done(TRUE, n_steps), TableRun(TABLE, HASTY, 2, n_steps)
    symbolic.advance(n_steps)
    assert symbolic.detections
    for column in symbolic.columns:
        np.testing.assert_array_equal(visible.log(column), symbolic.log(column), err_msg=column)
    assert [(detection.step, detection.event) for detection in visible.detections] == [
        (detection.step, detection.event) for detection in symbolic.detections
    ]
    np.testing.assert_array_equal(visible.faces(), symbolic.faces())
    assert visible.stage.world.rendered_frames < n_steps  # nobody looked


def test_images_tell_what_the_state_is(drawn):
    run = drawn
    counts, objects = run.confusion(), run.object_confusion()
    assert counts.sum() == objects.sum() == run.steps_done
    assert counts[:-1, :-1].max(axis=1).sum() >= 0.97 * counts[:, :-1].sum()
    assert counts[-1, -1] == counts[:, -1].sum()
    assert np.trace(objects) >= 0.97 * run.steps_done
    named = named_by_majority(run.agent.variables, counts, table_variables(TABLE).sensors[0].values)
    assert {"at spot 1", "at spot 2", "at spot 3", "at robot"} <= {v.split(" (")[0] for v in named.sensors[0].values}
    assert run.more()["sensed_object_by_truth"]["object"] == objects[0].tolist()


def test_names_differ_though_a_face_was_mostly_not_there(run):
    """With imprecise heads a category can be sensed most often where there was no face to see."""
    values, truth = run.agent.variables.sensors[0].values, table_variables(TABLE).sensors[0].values
    counts = np.zeros((len(values), len(truth)), int)
    counts[:, truth.index("not seen")] = 1
    named = named_by_majority(run.agent.variables, counts, truth).sensors[0].values
    assert named[-1] == "not seen"
    assert named[:2] == ("not seen (2)", "not seen (3)")


def test_frontal_is_what_greeted_it(run):
    """R1 is seen when she looks at the robot, R2 when at something else, each only while the robot looks at her."""
    at_robot, elsewhere = run.faces() == 3, run.faces() < 3
    assert np.mean(run.log("frontal face") == at_robot) > 0.98
    assert np.mean(run.log("profile") == elsewhere) > 0.98


def test_a_step_is_an_image(run):
    assert run.stage.world.rendered_frames == run.steps_done + SHORT.exploration + SHORT.calibration


def test_the_centre_of_an_image_tells_what_all_of_it_does():
    """Of two robots that know the same views of faces."""
    unsteady = replace(CENTRE, stage=StageConfig(motor_noise_deg=3.0))
    narrow, whole = (RenderedRun(TABLE, replace(unsteady, draws=draws), HASTY, 2, 1) for draws in ("centre", "all"))
    rng, at_face = np.random.default_rng(0), 0
    for _ in range(300):
        narrow.body.perception.faces = pickle.loads(pickle.dumps(whole.body.perception.faces))
        action = rng.integers((TABLE.spots + 1, TABLE.gestures))
        views = []
        for robot in (narrow, whole):
            robot.body.act(action)
            views.append(robot.body.observe(int(action[1]), whole.heads))
        assert views[0].face == views[1].face and views[0].object == views[1].object
        at_face += views[0].face
    assert at_face > 20
    narrow.close()
    whole.close()


@pytest.mark.parametrize(("radius_deg", "half"), [(3.5, 48), (4.729, 56)])
def test_a_face_is_drawn_whole_wherever_the_detector_may_find_it_at_the_centre(radius_deg, half):
    body = Body(TABLE, StageConfig(), SensesConfig(centre_radius_deg=radius_deg), np.random.SeedSequence(0))
    body.narrow()
    assert body.stage.world.eye.part == (160 - half, 120 - half, 160 + half, 120 + half)
    body.close()


def test_beside_the_centre_nothing_is_drawn_and_no_face_learned():
    narrow = RenderedRun(TABLE, CENTRE, HASTY, 2, 1)
    narrow.advance(1)  # a table begins with eye contact
    perception = narrow.body.perception
    known = perception.faces.bank.n
    for spot in (0, 1, 2) * 20:
        narrow.body.act(np.array([spot, 0]))
        assert not narrow.body.observe(0, narrow.heads).face
        assert perception.fix == NO_FACE and perception.faces.bank.n == known
    image = narrow.stage.world.image()
    drawn = [np.flatnonzero(image.any(axis=(axis, 2))) for axis in (1, 0)]
    assert image.shape == (240, 320, 3)
    assert [(where.min(), where.max()) for where in drawn] == [(72, 167), (112, 207)]
    narrow.close()


def test_the_same_seed_is_the_same_run_however_it_is_interrupted(drawn):
    run, config = drawn, drawn.config
    assert_same(steps_done(config, 400, stops=(1, 37)), run)
    other = RenderedRun(TABLE, config, HASTY, 2, 400)
    other.advance(123)
    frozen = pickle.dumps(other)
    other.advance(10)
    other.close()
    again = pickle.loads(frozen)
    again.advance(400)
    assert_same(again, run)
    np.testing.assert_array_equal(again.stage.world.image(), run.stage.world.image())
    again.close()
    assert copy.deepcopy(again).stage.world.closed


def test_seeds_differ(run):
    assert not np.array_equal(steps_done(SHORT, 100, seed=3).log("shift gaze"), run.log("shift gaze")[:100])


def test_who_sees_nothing_senses_nothing():
    run = RenderedRun(TABLE, SHORT, HASTY, 2, 40)
    count = len(run.stage.objects) + 1
    nothing = Percept(np.zeros(count, bool), np.full((count, 2), np.nan), np.zeros(count, bool))
    run.body.perception.glance = lambda observation: nothing
    run.advance(40)
    assert (run.log("caregiver's face") == len(run.agent.variables.sensors[0].values) - 1).all()
    for name in ("frontal face", "profile", "object"):
        assert not run.log(name).any()


@pytest.mark.parametrize("wrong", [{"calibration": 0}, {"exploration": 0}])
def test_options_that_cannot_work(wrong):
    with pytest.raises(ConfigError):
        RenderedConfig(**wrong)


def test_the_centre_is_drawn_by_opengl_where_nothing_is_learned_beside_it():
    with pytest.raises(ConfigError, match=r"rendered\.stage\.world\.renderer opengl"):
        RenderedConfig(StageConfig(WorldConfig(renderer="warp")), draws="centre")
    with pytest.raises(ConfigError, match=r"rendered\.draws all"):
        RenderedDevelopmentConfig.of(resolution="growing", rendered={"draws": "centre"})


def test_parts_of_perception_have_names():
    with pytest.raises(ConfigError, match="face, category, object"):
        SensesConfig(state=("ears",))


def test_the_command_leaves_results_and_a_film_and_resumes_to_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr(rows, "BUFFER_BYTES", 24)  # two turns
    config = RenderedDevelopmentConfig(
        steps=6, agent=HASTY, rendered=replace(SHORT, stage=StageConfig(variation="none"))
    )
    whole = run_development(config, DevelopmentOptions(tmp_path / "whole", video=True))
    assert (tmp_path / "whole" / "video.mp4").stat().st_size > 10_000
    assert not list((tmp_path / "whole").glob("moment*"))
    assert whole.summary.more["caregiver"] == "robin" and whole.summary.steps == 6

    def stop(run, found):
        if run.steps_done == 2:
            raise KeyboardInterrupt

    options = DevelopmentOptions(tmp_path / "stopped", checkpoint_every=2)
    with pytest.raises(KeyboardInterrupt):
        run_development(config, options, stop)
    assert run_development(config, replace(options, resume=True)) == whole


def test_killed_between_film_and_results(tmp_path, monkeypatch):
    """The film is made again, not left empty."""
    config = RenderedDevelopmentConfig(
        steps=3, agent=HASTY, rendered=replace(SHORT, stage=StageConfig(variation="none"))
    )
    leave, options = development.Finished.save, DevelopmentOptions(tmp_path, video=True)

    def killed(*_):
        raise SystemExit(9)

    monkeypatch.setattr(development.Finished, "save", killed)
    with pytest.raises(SystemExit):
        run_development(config, options)
    film = (tmp_path / "video.mp4").read_bytes()
    monkeypatch.setattr(development.Finished, "save", leave)
    run_development(config, replace(options, resume=True))
    assert (tmp_path / "video.mp4").read_bytes() == film
    assert not list(tmp_path.glob("moment*"))


def test_a_run_at_the_symbolic_table_is_not_filmed(tmp_path):
    with pytest.raises(ConfigError, match="world rendered"):
        run_development(TableDevelopmentConfig(steps=10), DevelopmentOptions(tmp_path, video=True))


def test_a_table_with_a_spot_that_is_not_there_is_no_run(run):
    made_up = pickle.loads(pickle.dumps(run))
    made_up.stage.table.order[0] = 10**6
    with pytest.raises(ValueError, match="must each occur once"):
        pickle.loads(pickle.dumps(made_up))
    made_up.close()


def test_what_is_no_value_of_a_sensor_does_not_reach_the_agent(run):
    made_up = pickle.loads(pickle.dumps(run))
    made_up.n_steps += 1
    made_up.sense = lambda number: made_up._s.fill(10**6)
    with pytest.raises(ObservationError, match="values of sensors"):
        made_up.advance(1)
    made_up.close()


def test_a_category_is_frontal_if_it_is_much_more_like_frontal_faces_than_others_are():
    rng = np.random.default_rng(0)
    where = np.repeat([[0.0, 0], [3, 0], [10, 0], [0, 10], [7, 7]], 5, axis=0)
    category = np.repeat(np.arange(5), 5)
    patterns = where + rng.normal(0, 0.1, where.shape)
    greeted = np.array([True, False, False, False, False, False])
    assert alike(patterns, category, greeted, 0.6).tolist() == [False, True, False, False, False, False]
    assert not alike(patterns, category, greeted, 0.2).any()
    assert not alike(patterns[:5], category[:5], greeted, 0.6).any(), "there is no other category"


def test_frontal_likeness_comes_with_the_preset_and_not_with_categories_that_grow():
    realtime, rendered = config_class("realtime"), config_class("rendered")
    assert realtime.of().realtime.senses.frontal_likeness == 0
    assert realtime.of(preset="local").realtime.senses.frontal_likeness > 0
    own = realtime.of(preset="local", realtime={"senses": {"frontal_likeness": 0.2}})
    assert own.realtime.senses.frontal_likeness == 0.2
    with pytest.raises(ConfigError, match=r"needs senses\.frontal_likeness 0"):
        rendered.of(resolution="growing", rendered={"senses": {"frontal_likeness": 0.5}})
