"""The three-layered network against its formula and numerical gradients, visual feedback's choice, the gate."""

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from jointattn_mj.baselines.turn_taking.agent import FEEDBACK, TurnTaker, TurnTakerConfig, feedback_target
from jointattn_mj.errors import ConfigError

INPUTS = 12


def robot(**options) -> TurnTaker:
    defaults = {"hidden": 7, "first_face_weight": 0.4, "first_weight": 0.5, "rate": 0.05}
    return TurnTaker(TurnTakerConfig(**(defaults | options)), INPUTS, np.random.default_rng(0))


def weights_of(taker: TurnTaker) -> list[np.ndarray]:
    return [array.astype(np.float64) for array in taker.network]


def forward(weights: list[np.ndarray], face: np.ndarray, heads: np.ndarray, scale: float) -> np.ndarray:
    face_weights, head_weights, threshold, out, out_threshold = weights
    hidden = np.tanh(heads / scale @ head_weights.T + face_weights @ face.astype(np.float64) + threshold)
    return (hidden @ out.T + out_threshold) * scale


def error(weights: list[np.ndarray], face: np.ndarray, heads: np.ndarray, movements: np.ndarray, scale: float) -> float:
    return float((((forward(weights, face, heads, scale) - movements) / scale) ** 2).sum() / 2)


def gradient(weights: list[np.ndarray], value_of: Callable[[], float], step: float = 1e-5) -> list[np.ndarray]:
    """Of ``value_of()``, by central differences; weights are moved, one after the other, and put back."""
    gradients = [np.empty_like(array) for array in weights]
    for array, slopes in zip(weights, gradients, strict=True):
        for index, value in np.ndenumerate(array):
            array[index] = value + step
            above = value_of()
            array[index] = value - step
            slopes[index] = (above - value_of()) / (2 * step)
            array[index] = value
    return gradients


def pairs(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    face = rng.standard_normal(INPUTS).astype(np.float32)
    return face, 20 * rng.standard_normal((4, 2)), 20 * rng.standard_normal((4, 2))


def test_the_command_is_a_three_layered_networks_output():
    taker = robot()
    face, heads, _ = pairs(1)
    expected = forward(weights_of(taker), face, heads, taker.config.angle_scale_deg)
    assert [taker.movement(face, head) for head in heads] == pytest.approx(expected, rel=1e-5)


def test_learning_is_one_step_down_the_gradient():
    taker, scale = robot(), 30.0
    weights = weights_of(taker)
    for seed in range(5):
        face, heads, movements = pairs(seed)
        slopes = gradient(weights, partial(error, weights, face, heads, movements, scale))
        for array, slope in zip(weights, slopes, strict=True):
            array -= taker.config.rate * slope
        taker.learn(face, heads, movements)
    for own, expected in zip(taker.network, weights, strict=True):
        assert own == pytest.approx(expected, abs=1e-5)


def test_it_learns_online_where_faces_look():
    taker, rng = robot(hidden=20, first_face_weight=0.1, first_weight=0.2, rate=0.02), np.random.default_rng(3)
    code = rng.standard_normal((2, INPUTS))

    def trial():
        goal = rng.uniform(-15, 15, 2)
        return (goal / 15 @ code).astype(np.float32), rng.uniform(-15, 15, (3, 2)), goal

    def error():
        trials = (trial() for _ in range(200))
        missed = [taker.movement(face, heads[0]) - (goal - heads[0]) for face, heads, goal in trials]
        return np.mean(np.hypot(*np.transpose(missed)))

    before = error()
    for _ in range(5000):
        face, heads, goal = trial()
        taker.learn(face, heads, goal - heads)
    assert before > 8
    assert error() < 2


def test_the_gate_opens_with_learning_time():
    taker = robot(gate_midpoint=100.0, gate_width=10.0)
    assert taker.gate(201)[[0, 100, 200]] == pytest.approx([1 / (1 + np.exp(10)), 0.5, 1 / (1 + np.exp(-10))])
    taker.time = 100
    assert taker.gate(1) == pytest.approx([0.5])
    assert robot(gate="shut").gate(3).tolist() == [0, 0, 0]
    assert robot(gate="open").gate(3).tolist() == [1, 1, 1]


@pytest.mark.parametrize(
    ("feedback", "kept", "by_network", "expected"),
    [
        ("nearest", -1, False, 2),  # at first the most interesting in view, that is a random one
        ("nearest", 1, False, 1),  # and it is kept
        ("nearest", 1, True, 3),  # until the network has moved the head
        ("kept", 1, True, 1),
        ("kept", 0, True, 2),  # lost from view
        ("interest", 1, True, 2),
    ],
)
def test_which_object_visual_feedback_moves_to(feedback, kept, by_network, expected):
    visible = np.array([False, True, True, True])
    off, interest = np.array([np.inf, 9.0, 8.0, 2.0]), np.array([0.9, 0.1, 0.7, 0.3])
    assert feedback_target(FEEDBACK.index(feedback), visible, off, interest, kept, by_network) == expected


def test_with_nothing_in_view_visual_feedback_has_no_target():
    unseen = np.zeros(3, bool)
    assert feedback_target(0, unseen, np.full(3, np.inf), np.ones(3), -1, False) == -1


@pytest.mark.parametrize(
    ("name", "value"), [("hidden", 0), ("gain", 0.0), ("gain", 1.5), ("rate", 0.0), ("centre_radius_deg", 0.0)]
)
def test_impossible_options_are_named(name, value):
    with pytest.raises(ConfigError, match=name):
        TurnTakerConfig(**{name: value})
