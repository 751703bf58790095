"""Face categories: as many as there are kinds of patterns, without being told."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jointattn_mj.errors import ConfigError
from jointattn_mj.perception.categories import FaceCategories, GroupingConfig, grouped, silhouette
from jointattn_mj.perception.som import SOM, SOMConfig


def clusters(count: int, each: int, rng: np.random.Generator, spread: float = 0.1) -> tuple[np.ndarray, np.ndarray]:
    """Patterns (n, 20) about ``count`` centres, and which centre."""
    centres, which = rng.normal(size=(count, 20)), np.repeat(np.arange(count), each)
    return centres[which] + spread * rng.normal(size=(len(which), 20)), which


@pytest.mark.parametrize("count", [2, 3, 5, 9])
def test_as_many_categories_as_kinds_of_patterns(count):
    rng = np.random.default_rng(count)
    patterns, which = clusters(count, 40, rng)
    som = SOM(20, SOMConfig(), rng)
    som.train(patterns, rng)
    categories = FaceCategories(som, patterns)
    assert categories.count == count
    for kind in range(count):
        assert len({categories.of(pattern) for pattern in patterns[which == kind]}) == 1
    assert {categories.of(patterns[which == kind][0]) for kind in range(count)} == set(range(count))


def brute_silhouette(points: np.ndarray, groups: np.ndarray) -> float:
    values = []
    for i, point in enumerate(points):
        apart = np.linalg.norm(points - point, axis=1)
        mine = (groups == groups[i]) & (np.arange(len(points)) != i)
        if not mine.any():
            values.append(0.0)
            continue
        own = apart[mine].mean()
        other = min(apart[groups == group].mean() for group in set(groups.tolist()) - {groups[i]})
        values.append((other - own) / max(own, other) if max(own, other) else 0.0)
    return float(np.mean(values))


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000), st.integers(2, 4))
def test_silhouette_of_weighted_points_is_that_of_as_many_points(seed, count):
    rng = np.random.default_rng(seed)
    points, weights = rng.normal(size=(8, 2)), rng.integers(1, 4, 8)
    groups = np.concatenate([np.arange(count), rng.integers(0, count, 8 - count)])
    distances = np.linalg.norm(points[:, None] - points, axis=2)
    alike = brute_silhouette(np.repeat(points, weights, axis=0), np.repeat(groups, weights))
    assert silhouette(distances, groups, weights) == pytest.approx(alike)


def test_few_points_are_each_a_group():
    assert grouped(np.zeros((1, 3)), np.array([5]), GroupingConfig()).tolist() == [0]
    assert grouped(np.eye(2), np.array([5, 1]), GroupingConfig()).tolist() == [0, 1]


def test_no_more_than_asked_for():
    rng = np.random.default_rng(0)
    patterns, _ = clusters(9, 20, rng)
    assert grouped(patterns, np.ones(len(patterns), int), GroupingConfig(most=4)).max() + 1 <= 4


@pytest.mark.parametrize("wrong", [{"most": 1}, {"linkage": "nearest"}])
def test_options_that_cannot_work(wrong):
    with pytest.raises(ConfigError):
        GroupingConfig(**wrong)


def test_one_face_is_not_enough():
    with pytest.raises(ConfigError, match="got 1"):
        FaceCategories(SOM(20), np.zeros((1, 20)))
