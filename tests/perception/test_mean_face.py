"""Mean and spread of a person's faces: what is coded is how a face deviates, which two people may share."""

import pickle

import numpy as np
import pytest

from jointattn_mj.errors import ConfigError, ObservationError
from jointattn_mj.perception.mean_face import MeanFace, MeanFaceConfig
from jointattn_mj.perception.som import SOM, SOMConfig, standardised

RNG = np.random.default_rng(0)
TURNS = RNG.normal(size=(40, 64)) * 0.3
"""What turning the head does to a face, the same in all people."""
PEOPLE = 2 * RNG.normal(size=(2, 64))


def faces(person: int) -> np.ndarray:
    return 128 + 40 * (PEOPLE[person] + TURNS)


def after(faces: np.ndarray) -> MeanFace:
    mean = MeanFace(64)
    for face in faces:
        mean.update(face)
    return mean


def test_mean_and_spread_of_standardised_faces():
    mean, seen = after(faces(0)), np.array([standardised(face) for face in faces(0)])
    np.testing.assert_allclose(mean.mean, seen.mean(axis=0), atol=1e-6)
    assert mean.spread == pytest.approx(np.sqrt(np.mean((seen - seen.mean(axis=0)) ** 2)), rel=1e-6)
    deviations = np.array([mean.deviation(face) for face in faces(0)])
    assert np.mean(deviations**2) == pytest.approx(1)


def test_the_size_of_a_deviation_tells_how_far_a_face_is_turned():
    mean, face = after(faces(0)), 40 * PEOPLE[0]
    small, large = (np.linalg.norm(mean.deviation(face + turn * TURNS[0])) for turn in (5, 40))
    assert large > 3 * small


def test_without_faces_or_with_one_alone_nothing_deviates():
    for count in (0, 1):
        assert not after(faces(0)[:count]).deviation(faces(0)[2]).any()


def test_what_is_known_from_before_gives_way_to_what_is_seen():
    """Mean and spread are those of all faces, the earlier ones counting as 20 and only within themselves."""
    before = after(faces(0))
    mean = MeanFace.from_arrays(before.arrays(), MeanFaceConfig(known=20))
    np.testing.assert_array_equal(mean.mean, before.mean)
    assert mean.spread == pytest.approx(before.spread)
    for face in faces(1):
        mean.update(face)
    second = after(faces(1))
    np.testing.assert_allclose(mean.mean, (before.mean + 2 * second.mean) / 3, atol=1e-12)
    assert mean.spread**2 == pytest.approx((before.spread**2 + 2 * second.spread**2) / 3)


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
            mean = after(faces(person))
            coded = [mean.deviation(face) if subtract else face for face in faces(person)]
            if person == 0:
                config = SOMConfig(updates=1500, sigma_end=0.3)
                som = SOM(64, config, np.random.default_rng(1), standardises=not subtract)
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


@pytest.mark.parametrize(
    "mean", [np.zeros((2, 2)), np.full(64, np.nan), np.array(["a"]), np.array(0.0), np.arange(64), np.full(64, 8.1)]
)
def test_what_is_no_mean_is_refused(mean):
    with pytest.raises(ConfigError, match="mean face: expected a row of numbers from"):
        MeanFace.from_arrays({"mean_face": mean, "mean_face_spread": np.array(1.0)}, MeanFaceConfig())


@pytest.mark.parametrize("spread", [np.ones(2), np.array(np.nan), np.array("a"), np.array(-0.1), np.array(3.0)])
def test_what_is_no_spread_is_refused(spread):
    with pytest.raises(ConfigError, match="spread of faces: expected a number from 0 to 2"):
        MeanFace.from_arrays({"mean_face": np.zeros(64), "mean_face_spread": spread}, MeanFaceConfig())


def test_whole_numbers_are_numbers():
    known = MeanFace.from_arrays({"mean_face": np.zeros(64, int), "mean_face_spread": np.array(1)}, MeanFaceConfig())
    assert known.spread == 1


@pytest.mark.parametrize("count", [0, 2])
@pytest.mark.parametrize(
    ("face", "error"),
    [(np.full(64, np.nan), ObservationError), (np.array(["a"]), ObservationError), (np.zeros(63), ConfigError)],
)
def test_what_is_no_face_is_refused_and_does_not_count(count, face, error):
    mean = after(faces(0)[:count])
    before = mean.arrays()
    for use in (mean.update, mean.deviation):
        with pytest.raises(error, match="pattern"):
            use(face)
    assert mean.count == count
    np.testing.assert_equal(mean.arrays(), before)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("_means", np.zeros(64)),
        ("_means", np.full((2, 64), np.nan)),
        ("_means", np.full((2, 64), 8.1)),
        ("_variances", np.array([0, np.inf])),
        ("_variances", np.array([-0.1, 0])),
        ("_waits", None),
        ("_waits", 4),
        ("count", -1),
    ],
)
def test_a_checkpoint_of_something_else_is_refused(name, value):
    mean = after(faces(0))
    again = pickle.loads(pickle.dumps(mean))
    np.testing.assert_equal(again.arrays(), mean.arrays())
    with pytest.raises(ValueError, match=r"must be|cannot have"):
        again.__setstate__({**vars(mean), name: value})
