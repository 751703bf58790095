"""The map orders faces, gives activations that sum to 1, and quantises as well as minisom."""

import numpy as np
import pytest
from minisom import MiniSom

from jointattn_mj.errors import ConfigError
from jointattn_mj.perception.som import SOM, SOMConfig, standardised


def blobs(n, seed=0, side=16):
    """(n, side * side) images of one blob at positions on a plane: a two-dimensional family of patterns."""
    rng = np.random.default_rng(seed)
    position = rng.uniform(0.2, 0.8, (n, 2, 1, 1)) * side
    y, x = np.mgrid[:side, :side]
    return np.exp(-((x - position[:, 0]) ** 2 + (y - position[:, 1]) ** 2) / 18).reshape(n, -1).astype(np.float32)


@pytest.fixture(scope="module")
def patterns():
    return blobs(600)


@pytest.fixture(scope="module")
def trained(patterns):
    som = SOM(256, SOMConfig(updates=4000, softness=1.0), np.random.default_rng(0))
    som.train(patterns, np.random.default_rng(1))
    return som


def test_quantises_as_well_as_minisom(trained, patterns):
    config = trained.config
    oracle = MiniSom(9, 9, 256, sigma=config.sigma_start, learning_rate=config.rate_start, random_seed=0)
    data = np.array([standardised(x) for x in patterns], float)
    oracle.train(data, 4000, random_order=True)
    test = blobs(200, seed=5)
    theirs = oracle.quantization_error(np.array([standardised(x) for x in test], float))
    assert trained.quantisation_error(test) < 1.05 * theirs


def test_errors_are_as_minisom_counts_them(trained, patterns):
    oracle = MiniSom(9, 9, 256)
    oracle._weights = trained.weights.reshape(9, 9, 256).astype(float)
    data = np.array([standardised(x) for x in patterns[:100]], float)
    assert trained.quantisation_error(patterns[:100]) == pytest.approx(oracle.quantization_error(data), rel=1e-4)
    assert trained.topographic_error(patterns[:100]) == pytest.approx(oracle.topographic_error(data), abs=1e-9)


def test_the_sheet_is_ordered(trained, patterns):
    assert trained.topographic_error(patterns) < 0.1
    untrained = SOM(256, trained.config, np.random.default_rng(0))
    assert untrained.topographic_error(patterns) > 0.5


def test_activations(trained, patterns):
    active = trained.activations(patterns[0])
    assert active.shape == (81,) and active.min() >= 0
    assert active.sum() == pytest.approx(1, abs=1e-5)
    assert active.argmax() == trained.winner(patterns[0])
    assert 1.2 < 1 / np.square(active).sum() < 40, "neither one cell alone nor all of them alike"
    distances = np.square(trained.weights - standardised(patterns[0])).sum(axis=1)
    expected = np.exp(-(distances - distances.min()) / (2 * trained.config.softness * trained.width))
    assert active == pytest.approx(expected / expected.sum(), abs=1e-4)


def test_softness_spreads_activations(trained, patterns):
    def spread(softness):
        som = SOM.from_arrays(trained.arrays(), SOMConfig(softness=softness))
        return 1 / np.square(som.activations(patterns[3])).sum()

    assert spread(0.2) < spread(1.0) < spread(5.0)


def test_brightness_and_contrast_do_not_count(trained, patterns):
    assert trained.activations(patterns[1] * 40 + 90) == pytest.approx(trained.activations(patterns[1]), abs=1e-4)
    assert np.isfinite(trained.activations(np.full(256, 7.0))).all()


def test_a_pattern_pulls_its_cell_and_less_its_neighbours():
    som = SOM(256, SOMConfig(sigma_start=1.0), np.random.default_rng(0))
    pattern = blobs(1, seed=9)[0]
    before = np.linalg.norm(som.weights - standardised(pattern), axis=1)
    winner = som.update(pattern)
    moved = 1 - np.linalg.norm(som.weights - standardised(pattern), axis=1) / before
    assert moved[winner] == pytest.approx(0.5, abs=1e-3)
    next_to = winner + 1 if winner % 9 < 8 else winner - 1
    assert moved[next_to] == pytest.approx(0.5 * np.exp(-0.5), abs=1e-3)


def test_two_numbers_are_taken_as_they_are():
    rng = np.random.default_rng(2)
    angles = np.stack([rng.uniform(-30, 30, 1500), rng.uniform(10, 35, 1500)], axis=1)
    som = SOM(2, SOMConfig(updates=3000), np.random.default_rng(0))
    som.train(angles, np.random.default_rng(1))
    assert som.quantisation_error(angles) < 3.0  # degrees; the cells are about 6 x 3 degrees apart
    centre = som.activations(np.array([10.0, 20.0])) @ som.weights
    assert centre == pytest.approx([10, 20], abs=2.5)


def test_contrast_counts_where_patterns_are_not_standardised(patterns):
    """Units tell a weak pattern from the same pattern when it is strong, as they must for deviations from a mean."""
    som = SOM(256, SOMConfig(updates=600), np.random.default_rng(0), standardises=False)
    for strength in np.random.default_rng(1).uniform(-1, 1, 600):
        som.update(strength * patterns[0])
    units = [som.winner(strength * patterns[0]) for strength in (-0.9, -0.3, 0.3, 0.9)]
    assert len(set(units)) == 4
    again = SOM.from_arrays(som.arrays(), som.config, standardises=False)
    assert [again.winner(strength * patterns[0]) for strength in (-0.9, -0.3, 0.3, 0.9)] == units


def test_saving_and_loading(trained, patterns, tmp_path):
    np.savez(tmp_path / "som.npz", **trained.arrays())
    with np.load(tmp_path / "som.npz") as saved:
        again = SOM.from_arrays(dict(saved), trained.config)
    assert (again.activations(patterns[2]) == trained.activations(patterns[2])).all()
    assert again.n_patterns == trained.n_patterns == 4000
    assert trained.images().shape == (9, 9, 16, 16)
    with pytest.raises(ConfigError, match="expected weights"):
        SOM.from_arrays(trained.arrays(), SOMConfig(rows=5))


def test_learning_is_deterministic(patterns):
    def learn():
        som = SOM(256, SOMConfig(updates=200), np.random.default_rng(3))
        som.train(patterns, np.random.default_rng(4))
        return som.weights

    assert (learn() == learn()).all()


def test_bad_input_is_refused(trained):
    with pytest.raises(ConfigError, match="256"):
        trained.activations(np.zeros(100))
    with pytest.raises(ConfigError, match="softness"):
        SOMConfig(softness=0)
    with pytest.raises(ConfigError, match="square"):
        SOM(2).images()
