"""Locations on the table: apart, within bounds, even, and repeatable."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jointattn_mj.errors import ConfigError
from jointattn_mj.scene.layout import Layout, LayoutConfig


def distances(positions: np.ndarray) -> np.ndarray:
    """Distances of all pairs of positions (n, 2)."""
    upper = np.triu_indices(len(positions), 1)
    return np.linalg.norm(positions[:, None] - positions[None], axis=2)[upper]


def unevenness(config: LayoutConfig, moves: int = 480, seed: int = 0) -> float:
    """Chi-square of how often cells are used while four objects are moved about, one at a time."""
    rng = np.random.default_rng(seed)
    layout = Layout(config, rng)
    objects = layout.fill(4)
    used = np.zeros(LayoutConfig().cells)
    low = np.array([config.x_range[0], config.y_range[0]])
    size = np.array([config.x_range[1], config.y_range[1]]) - low
    for _ in range(moves):
        moved = rng.integers(4)
        objects[moved] = layout.draw(np.delete(objects, moved, axis=0))
        used[tuple(((objects[moved] - low) / size * used.shape).astype(int))] += 1
    expected = moves / used.size
    return float(((used - expected) ** 2 / expected).sum())


@given(st.integers(0, 2**32 - 1), st.integers(1, 8))
def test_objects_lie_on_the_table_and_apart(seed, count):
    config = LayoutConfig()
    positions = Layout(config, np.random.default_rng(seed)).fill(count)
    assert positions.shape == (count, 2)
    assert np.all(
        (positions >= [config.x_range[0], config.y_range[0]]) & (positions <= [config.x_range[1], config.y_range[1]])
    )
    assert np.all(distances(positions) >= config.spacing)


def test_a_new_place_keeps_the_spacing():
    layout = Layout(LayoutConfig(), np.random.default_rng(1))
    objects = layout.fill(4)
    for _ in range(100):
        objects[0] = layout.draw(objects[1:])
        assert distances(objects).min() >= layout.config.spacing


def test_places_are_more_even_than_uniform_draws():
    even = np.mean([unevenness(LayoutConfig(), seed=seed) for seed in range(3)])
    uniform = np.mean([unevenness(LayoutConfig(evenness=1), seed=seed) for seed in range(3)])
    degrees_of_freedom = 23  # the mean of a chi-square over 24 cells, had all been equally likely
    assert even < 0.1 * degrees_of_freedom
    assert uniform > 0.5 * degrees_of_freedom


def test_same_seed_same_places():
    first, second, other = (Layout(LayoutConfig(), np.random.default_rng(seed)).fill(4) for seed in (5, 5, 6))
    np.testing.assert_array_equal(first, second)
    assert not np.array_equal(first, other)


def test_a_table_that_is_too_full_is_an_error():
    with pytest.raises(ConfigError, match="no room for 4 objects"):
        Layout(LayoutConfig(spacing=0.5), np.random.default_rng(0)).fill(4)
    with pytest.raises(ConfigError, match="no room"):
        Layout(LayoutConfig(spacing=2.0), np.random.default_rng(0)).draw(np.array([[1.0, 0.0]]))


@pytest.mark.parametrize("wrong", [{"spacing": 0}, {"evenness": 0}, {"x_range": (1.0, 1.0)}, {"y_range": (0.3, -0.3)}])
def test_impossible_settings_are_errors(wrong):
    with pytest.raises(ConfigError, match=next(iter(wrong))):
        LayoutConfig(**wrong)
