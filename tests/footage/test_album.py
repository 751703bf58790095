"""Faces kept from a video, and the map learned from them."""

import numpy as np

from jointattn_mj.footage.faces import FaceAlbum
from jointattn_mj.perception.som import SOMConfig


def album(capacity: int, offered: int, dimension: int = 16) -> FaceAlbum:
    """Patterns that tell when they were offered, in their first number."""
    kept, rng = FaceAlbum(capacity, dimension, np.random.default_rng(1)), np.random.default_rng(2)
    for number in range(offered):
        pattern = rng.normal(0, 1, dimension).astype(np.float32)
        pattern[0] = number
        kept.add(pattern, number / 10)
    return kept


def test_all_are_kept_while_there_is_room():
    kept = album(50, 30)
    assert kept.patterns[:, 0].tolist() == list(range(30))
    np.testing.assert_allclose(kept.times, np.arange(30) / 10)


def test_an_even_sample_of_more():
    """Each with the same chance, with its own time, and no more memory than at first."""
    kept = album(200, 5000)
    assert kept.patterns.shape == (200, 16)
    np.testing.assert_allclose(kept.patterns[:, 0], np.round(kept.times * 10))
    counts = np.histogram(kept.times, 5, (0, 500))[0]
    assert counts.min() > 20 and counts.sum() == 200
    assert (np.diff(kept.times) > 0).all()


def test_a_map_of_few_faces_is_learned_to_the_end():
    config = SOMConfig(rows=4, columns=4, updates=200)
    kept = album(50, 12)
    som = kept.learn(config)
    assert som.n_patterns == 200
    table = kept.table(som)
    assert table.num_rows == 12
    winners = [som.winner(pattern) for pattern in kept.patterns]
    assert [4 * row["row"] + row["column"] for row in table.to_pylist()] == winners
    assert len(set(winners)) >= 6
    np.testing.assert_array_equal(som.weights, album(50, 12).learn(config).weights)
