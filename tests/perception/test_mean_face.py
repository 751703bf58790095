"""The mean of a person's faces: what is coded is how a face deviates from it, which two people may share."""

import numpy as np
import pytest

from jointattn_mj.errors import ConfigError
from jointattn_mj.perception.mean_face import MeanFace, MeanFaceConfig
from jointattn_mj.perception.som import SOM, SOMConfig, standardised

RNG = np.random.default_rng(0)
TURNS = RNG.normal(size=(40, 64)) * 0.3
"""What turning the head does to a face, the same in all people."""
PEOPLE = 2 * RNG.normal(size=(2, 64))


def faces(person: int) -> np.ndarray:
    return 128 + 40 * (PEOPLE[person] + TURNS)


def test_it_is_the_mean_of_standardised_faces():
    mean = MeanFace(64)
    for face in faces(0):
        mean.update(face)
    np.testing.assert_allclose(mean.mean, np.mean([standardised(face) for face in faces(0)], axis=0), atol=1e-5)


def test_old_faces_are_forgotten():
    mean = MeanFace(64, MeanFaceConfig(most=20))
    for person in (0, 1):
        for _ in range(10):
            for face in faces(person):
                mean.update(face)
    first, second = (np.mean([standardised(face) for face in faces(person)], axis=0) for person in (0, 1))
    assert np.linalg.norm(mean.mean - second) < 0.1 * np.linalg.norm(mean.mean - first)


def test_a_map_of_deviations_serves_for_another_person():
    """The unit that stands for a turned face of one person stands for that of another; without the mean it does not."""

    def same_units(subtract: bool) -> float:
        units = []
        for person in (0, 1):
            mean = MeanFace(64)
            for face in faces(person):
                mean.update(face)
            coded = [mean.deviation(face) if subtract else face for face in faces(person)]
            if person == 0:
                som = SOM(64, SOMConfig(updates=1500, sigma_end=0.3), np.random.default_rng(1))
                som.train(np.array(coded), np.random.default_rng(2))
            units.append([som.winner(code) for code in coded])
        return float(np.mean(np.equal(*units)))

    assert same_units(True) > 0.8
    assert same_units(False) < 0.3


def test_one_face_in_several_counts():
    mean, looks = MeanFace(64, MeanFaceConfig(every=3)), []
    for frame in range(9):
        mean.look(lambda frame=frame: looks.append(frame) or faces(0)[frame])
    assert looks == [2, 5, 8]
    assert mean.count == 3


@pytest.mark.parametrize("mean", [np.zeros((2, 2)), np.full(64, np.nan), np.array(["a"]), np.arange(64)])
def test_what_is_no_mean_is_refused(mean):
    with pytest.raises(ConfigError, match="mean face: expected a row of finite numbers"):
        MeanFace.from_array(mean, MeanFaceConfig())
