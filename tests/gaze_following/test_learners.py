"""The online contingency learner: what it learns, what it keeps apart, what it refuses."""

import numpy as np
import pytest

from jointattn_mj.errors import ConfigError
from jointattn_mj.gaze_following.cross_situational import CrossSituationalLearner
from jointattn_mj.gaze_following.learners import (
    Learner,
    LearnerConfig,
    LinearLearner,
    Locations,
    PopulationCode,
    PopulationLearner,
)
from jointattn_mj.gaze_following.learners import make_learner as make
from jointattn_mj.scene.camera import off_centre

CODES = ("population", "linear", "network", "cross_situational")


def make_learner(config: LearnerConfig, inputs: int) -> Learner:
    return make(config, inputs, np.random.default_rng(5))


def faces(count: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Activations (count, 81) of a made-up map that is laid out like head angles, and the commands (count, 2)."""
    angles = rng.uniform(-1, 1, (count, 2))
    cells = np.stack(np.meshgrid(np.linspace(-1, 1, 9), np.linspace(-1, 1, 9), indexing="ij"), -1).reshape(81, 2)
    active = np.exp(-0.5 * (np.linalg.norm(angles[:, None] - cells, axis=2) / 0.2) ** 2)
    commands = np.column_stack([20 * angles[:, 0], -14 + 8 * angles[:, 1]])
    return active / active.sum(axis=1, keepdims=True), commands


def errors(learner, activations: np.ndarray, commands: np.ndarray) -> np.ndarray:
    return np.array([off_centre(learner.predict(a), c) for a, c in zip(activations, commands, strict=True)])


@pytest.mark.parametrize(
    ("code", "rate", "limit"), [("population", 0.1, 1.5), ("linear", 0.3, 1.5), ("network", 0.1, 2.5)]
)
def test_learns_a_map(code, rate, limit):
    rng = np.random.default_rng(0)
    learner = make_learner(LearnerConfig(code=code, rate=rate), 81)
    activations, commands = faces(1200, rng)
    naive = np.median(errors(learner, activations[-200:], commands[-200:]))
    for face, command in zip(activations[:1000], commands[:1000], strict=True):
        learner.learn(face, Locations.only(command))
    assert np.median(errors(learner, activations[1000:], commands[1000:])) < limit < naive


def compete(code: str) -> np.ndarray:
    """One face, two directions in turn: the right one three times in five."""
    learner = make_learner(LearnerConfig(code=code), 4)
    face = np.array([0.7, 0.1, 0.1, 0.1])
    for step in range(1000):
        learner.learn(face, Locations.only([12.0, -15.0] if step % 5 in (0, 2, 4) else [-12.0, -15.0]))
    return learner.predict(face)


def test_population_keeps_directions_apart_and_linear_averages():
    np.testing.assert_allclose(compete("population"), [12, -15], atol=0.8)
    np.testing.assert_allclose(compete("linear"), [12 / 5, -15], atol=1.0)


@pytest.mark.parametrize("code", ["population", "linear"])
def test_one_step_of_the_delta_rule(code):
    """With rate 1 the normalised delta rule makes the output for this input equal to the reference at once."""
    learner = make_learner(LearnerConfig(code=code, rate=1.0, context=0.0), 5)
    face, command = np.array([0.4, 0.3, 0.2, 0.1, 0.0]), np.array([10.0, -12.0])
    learner.learn(face, Locations.only(command))
    np.testing.assert_allclose(learner.predict(face), command, atol=0.35 if code == "population" else 1e-9)
    output = np.tensordot(face, learner.weights()[:5], 1)
    if code == "population":
        pans, tilts = np.linspace(-25, 25, 21), np.linspace(-30, 0, 11)
        bump = np.exp(-((pans[:, None] - 10) ** 2 + (tilts - -12) ** 2) / (2 * 1.5**2))
        np.testing.assert_allclose(output, bump, atol=1e-12)
    assert not learner.weights()[4].any()  # a silent cell learns nothing


def told_apart(context: float) -> np.ndarray:
    """A direction that comes with every face, and for the second face one of its own, half as often."""
    learner = make_learner(LearnerConfig(context=context), 2)
    always, own = np.array([15.0, -15.0]), np.array([-15.0, -15.0])
    for step in range(3000):
        face = np.eye(2)[step % 2]
        learner.learn(face, Locations.only(own if step % 2 and step % 5 < 2 else always))
    return learner.predict(np.array([0.0, 1.0]))


def test_context_takes_what_comes_whatever_the_face():
    np.testing.assert_allclose(told_apart(context=0.0), [15, -15], atol=0.8)
    np.testing.assert_allclose(told_apart(context=2.0), [-15, -15], atol=0.8)


def test_predictions_stay_in_range():
    learner = make_learner(LearnerConfig(rate=1.0), 3)
    for command in ((90.0, 40.0), (-90.0, -80.0)):
        learner.learn(np.array([1.0, 0.0, 0.0]), Locations.only(command))
        pan, tilt = learner.predict(np.array([1.0, 0.0, 0.0]))
        assert -25 <= pan <= 25
        assert -30 <= tilt <= 0


@pytest.mark.parametrize("code", CODES)
def test_the_object_in_view_that_was_reached_scores_highest(code):
    """Whatever the code: two faces, each with a place of its own, and a third location that neither leads to."""
    learner = make_learner(LearnerConfig(code=code), 2)
    left, right, middle = [15.0, -12.0], [-15.0, -12.0], [0.0, -25.0]
    for step in range(400):
        learner.learn(np.eye(2)[step % 2], Locations.only(right if step % 2 else left))
    locations = Locations(np.array([middle, left, right]))
    assert [int(np.argmax(learner.score(face, locations))) for face in np.eye(2)] == [1, 2]
    assert learner.score(np.eye(2)[0], Locations(np.zeros((0, 2)))).shape == (0,)


@pytest.mark.parametrize("code", ["population", "linear", "network"])
def test_the_dissertation_learns_from_the_object_reached_alone(code):
    learner = make_learner(LearnerConfig(code=code), 3)
    before = learner.weights()
    learner.learn(np.ones(3), Locations(np.array([[3.0, -10.0], [-3.0, -10.0]])))
    np.testing.assert_array_equal(learner.weights(), before)


@pytest.mark.parametrize("code", CODES)
def test_weights_round_trip(code):
    config = LearnerConfig(code=code)
    first, second = make_learner(config, 81), make_learner(config, 81)
    activations, commands = faces(30, np.random.default_rng(1))
    for face, command in zip(activations, commands, strict=True):
        first.learn(face, Locations.only(command))
    kept = first.weights()
    second.load(kept)
    first.learn(activations[0], Locations.only(commands[0]))  # leaves neither the copy nor the other learner untouched
    np.testing.assert_array_equal(second.weights(), kept)
    second.learn(activations[0], Locations.only(commands[0]))
    np.testing.assert_array_equal(second.weights(), first.weights())
    for activation in activations:
        np.testing.assert_array_equal(second.predict(activation), first.predict(activation))


@pytest.mark.parametrize("code", CODES)
def test_foreign_weights(code):
    learner = make_learner(LearnerConfig(code=code), 81)
    with pytest.raises(ConfigError, match="must have shape"):
        learner.load(learner.weights()[:-1])
    with pytest.raises(ConfigError, match="finite"):
        learner.load(np.full(learner.weights().shape, np.nan))
    for other in set(CODES) - {code}:
        with pytest.raises(ConfigError, match=r"another learner\.code"):
            learner.load(make_learner(LearnerConfig(code=other), 81).weights())


def test_codes():
    assert isinstance(make_learner(LearnerConfig(), 3), PopulationLearner)
    assert isinstance(make_learner(LearnerConfig(code="linear"), 3), LinearLearner)
    assert isinstance(make_learner(LearnerConfig(code="cross_situational"), 3), CrossSituationalLearner)


@pytest.mark.parametrize(
    "options",
    [{"pairs": "in_view"}, {"base": "in_view"}, {"competition": 1.0}, {"forgetting": 0.1}, {"smoothing": 1.0}],
)
@pytest.mark.parametrize("code", ["population", "linear", "network"])
def test_options_of_another_learner(code, options):
    """They would be ignored."""
    with pytest.raises(ConfigError, match=f"{next(iter(options))} .* needs learner.code cross_situational; got {code}"):
        LearnerConfig(code=code, **options)
    LearnerConfig(code="cross_situational", **options)


@pytest.mark.parametrize("options", [{"rate": 0.0}, {"tuning_deg": 0}, {"units": (2, 11)}, {"pan_range_deg": (5, -5)}])
def test_impossible_options(options):
    with pytest.raises(ConfigError, match=next(iter(options))):
        LearnerConfig(**options)


def test_units_of_a_code_lie_in_directions():
    code = PopulationCode(LearnerConfig())
    with pytest.raises(ValueError, match="directions of units"):
        code.__setstate__({**vars(code), "_pans": np.full(code.shape[0], np.inf)})
