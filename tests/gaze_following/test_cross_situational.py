"""The cross-situational learner: contingency in place of co-occurrence."""

import numpy as np
import pytest

from jointattn_mj.errors import ConfigError
from jointattn_mj.gaze_following.cross_situational import CrossSituationalLearner
from jointattn_mj.gaze_following.learners import LearnerConfig, Locations
from jointattn_mj.gaze_following.presets import LEARNER
from jointattn_mj.io.checkpoint import load, save
from jointattn_mj.scene.camera import off_centre

FACES, TABLE = 4, np.array([[-18.0, -12.0], [-6.0, -18.0], [6.0, -12.0], [18.0, -18.0]])
"""Face i looks at the i-th location."""


def learner(**options) -> CrossSituationalLearner:
    return CrossSituationalLearner(LearnerConfig(code="cross_situational", **options), FACES)


def look(rng: np.random.Generator, others: int = 2) -> tuple[int, Locations]:
    """A face, and the locations in view: the one that it looks at, and some of the rest; none was reached."""
    face = int(rng.integers(FACES))
    rest = rng.permutation(np.delete(np.arange(FACES), face))[:others]
    return face, Locations(TABLE[rng.permutation([face, *rest])])


def right(learned: CrossSituationalLearner) -> float:
    """Share of faces whose own location scores highest when all locations are in view."""
    scores = [learned.score(face, Locations(TABLE)) for face in np.eye(FACES)]
    return float(np.mean(np.argmax(scores, axis=1) == np.arange(FACES)))


def test_it_learns_from_looks_alone():
    """No object is ever reached; every look shows the right object among others."""
    learned, rng = CrossSituationalLearner(LEARNER, FACES), np.random.default_rng(0)
    for _ in range(200):
        face, locations = look(rng)
        learned.learn(np.eye(FACES)[face], locations)
    assert right(learned) == 1
    for face, location in zip(np.eye(FACES), TABLE, strict=True):
        assert off_centre(learned.predict(face), location) < 1.5
    assert "looks at the face" in repr(learned)


def bystander(learned: CrossSituationalLearner) -> float:
    """One object lies still, in view with every face; the others come and go. Share right with it among them."""
    still, rng = np.array([[0.0, -25.0]]), np.random.default_rng(1)
    for _ in range(300):
        face = int(rng.integers(FACES))
        own = TABLE[face : face + 1] if rng.random() < 0.7 else TABLE[rng.integers(FACES, size=1)]
        learned.learn(np.eye(FACES)[face], Locations(np.vstack([still, own])))
    scores = [learned.score(face, Locations(np.vstack([TABLE, still]))) for face in np.eye(FACES)]
    return float(np.mean(np.argmax(scores, axis=1) == np.arange(FACES)))


def test_the_base_rate_takes_what_comes_with_every_face():
    assert bystander(learner(pairs="in_view")) == 0
    assert bystander(learner(pairs="in_view", base="in_view")) == 1


def test_evidence_is_the_pointwise_mutual_information():
    """Counted by hand: in three looks of four with face 0 something lay at location 0, in four of eight altogether."""
    learned = learner(pairs="in_view", base="in_view", smoothing=1e-6, tuning_deg=0.1, units=(9, 5))
    pans, tilts = np.linspace(-25, 25, 9), np.linspace(-30, 0, 5)
    here, there = [pans[2], tilts[1]], [pans[6], tilts[3]]
    for face, location in [(0, here)] * 3 + [(0, there)] + [(1, here)] + [(1, there)] * 3:
        learned.learn(np.eye(FACES)[face], Locations(np.array([location])))
    evidence = learned.score(np.eye(FACES)[0], Locations(np.array([here, there])))
    np.testing.assert_allclose(evidence, np.log([(3 / 4) / (4 / 8), (1 / 4) / (4 / 8)]), atol=1e-5)
    without = learner(pairs="in_view", smoothing=1e-6, tuning_deg=0.1, units=(9, 5))
    without.load(learned.weights())
    np.testing.assert_allclose(
        without.score(np.eye(FACES)[0], Locations(np.array([here, there]))), np.log([3 / 4, 1 / 4]), atol=1e-5
    )


def test_in_competition_the_better_object_counts_for_more():
    def shares(**options) -> np.ndarray:
        """What two objects in view add to the counts of a face of whom one of them is known."""
        learned = learner(pairs="in_view", base="in_view", tuning_deg=0.1, **options)
        for _ in range(12):
            learned.learn(np.eye(FACES)[0], Locations(TABLE[:1]))
            learned.learn(np.eye(FACES)[1], Locations(TABLE[1:2]))
        before = learned.weights()
        learned.learn(np.eye(FACES)[0], Locations(TABLE[:2]))
        added = (learned.weights() - before)[0, :-1].reshape(21, 11)
        left = added[:6].sum()
        return np.array([left, added.sum() - left])

    np.testing.assert_allclose(shares(), [0.5, 0.5])
    own, other = shares(competition=1.0)
    assert own > 0.95 and own + other == pytest.approx(1)
    np.testing.assert_allclose(shares(competition=1.0, compete_after=100), [0.5, 0.5])


def test_forgetting():
    learned = learner(pairs="in_view", base="in_view", forgetting=0.5)
    for _ in range(30):
        learned.learn(np.eye(FACES)[0], Locations(TABLE[:1]))
    assert learned.weights()[-1, -1] == pytest.approx(2)  # 1 + 1/2 + 1/4 and so on


def test_pairs_reached_counts_the_object_reached():
    """Others in view count for the base rate, and compete for the weight of the pair."""
    learned = learner(base="in_view")
    learned.learn(np.eye(FACES)[0], Locations(TABLE, TABLE[2]))
    learned.learn(np.eye(FACES)[0], Locations(TABLE))  # nothing reached
    counts = learned.weights()
    assert counts[0, :-1].sum() == pytest.approx(1) and counts[0, -1] == 1
    assert counts[-1, -1] == 2
    assert np.argmax(learned.score(np.eye(FACES)[0], Locations(TABLE))) == 2
    rival = learner(base="in_view", competition=1.0, compete_after=0)
    rival.load(counts)
    rival.learn(np.eye(FACES)[0], Locations(TABLE, TABLE[1]))
    assert 0 < rival.weights()[0, -1] - 1 < 0.1


@pytest.mark.parametrize("config", [LEARNER, LearnerConfig(code="cross_situational", forgetting=0.1)])
def test_without_objects_nothing_is_learned_and_nothing_forgotten(config):
    learned = CrossSituationalLearner(config, FACES)
    learned.learn(np.eye(FACES)[0], Locations(TABLE[:1], TABLE[0]))
    before = learned.weights()
    learned.learn(np.eye(FACES)[0], Locations(np.zeros((0, 2))))
    np.testing.assert_array_equal(learned.weights(), before)


def test_what_lies_beyond_the_units_counts_for_the_nearest():
    """However far, and however narrow the bumps."""
    learned = learner(pairs="in_view", tuning_deg=0.01)
    learned.learn(np.eye(FACES)[0], Locations(np.array([[170.0, 80.0]])))
    assert np.isfinite(learned.weights()).all()
    np.testing.assert_allclose(learned.predict(np.eye(FACES)[0]), [25, 0], atol=1.5)


def test_counts_of_another_kind():
    learned = learner()
    with pytest.raises(ConfigError, match="counts, 0 or more"):
        learned.load(learned.weights() - 1)


def test_through_a_checkpoint(tmp_path):
    learned = CrossSituationalLearner(LEARNER, FACES)
    learned.learn(np.eye(FACES)[0], Locations(TABLE))
    save(tmp_path / "c", learned, {})
    again = load(tmp_path / "c", {})
    for each in (learned, again):
        each.learn(np.eye(FACES)[1], Locations(TABLE))
    np.testing.assert_array_equal(again.weights(), learned.weights())
