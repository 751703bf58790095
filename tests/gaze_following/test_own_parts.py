"""Sessions with parts of one's own: they are used, and a run goes on with them after a stop."""

import signal
from dataclasses import replace

import numpy as np
import pyarrow.parquet as pq
import pytest

from jointattn_mj.errors import CheckpointError, ObservationError
from jointattn_mj.gaze_following.agent import FamiliariseConfig, GazeFollower, RobotConfig
from jointattn_mj.gaze_following.learners import LinearLearner
from jointattn_mj.gaze_following.run import SessionOptions, run_session
from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.perception.state import StatePerception
from jointattn_mj.scene.caregiver import TransferScript
from jointattn_mj.scene.model import rest_height
from jointattn_mj.scene.world import World

pytestmark = pytest.mark.integration

CONFIG = SessionConfig(
    minutes=1, seed=5, perception="state", robot=RobotConfig(familiarise=FamiliariseConfig(minutes=0.05))
)


class Fond(TransferScript):
    """Wants the last object every other time."""

    def next_target(self, rng):
        last = len(self.objects) - 1
        return super().next_target(rng) if self.target == last else last


class FondWorld(World):
    def new_caregiver(self, head, arm, rng):
        config, count = self.config, len(self.config.scene.objects)
        return Fond(config.behaviour, config.layout, count, rest_height(config.scene), head, arm, rng)


class SharpEyed(StatePerception):
    """Sees faces in thousandths of a degree."""

    def face_pattern(self):
        return 1000 * super().face_pattern()


class Angles(GazeFollower):
    """Learns from the pattern itself, not from the map's activations."""

    def __init__(self, *parts):
        super().__init__(*parts)
        self.learner = LinearLearner(self.config.learner, self.perceiver.pattern_size)

    def face_input(self):
        return self.perceiver.face_pattern() / 1000


class OwnSession(SessionRun):
    def new_world(self, seed):
        return FondWorld.build(self.config.world, seed)

    def new_perceiver(self, rng):
        return SharpEyed(self.config.state, self.world, rng)

    def new_robot(self, perceiver, seed):
        return Angles(self.config.robot, perceiver, len(self.names) - 1, seed)


def targets(folder) -> list[str]:
    """What the caregiver looked at, each time anew."""
    names = pq.read_table(folder / "frames.parquet")["target"].to_pylist()
    return [name for before, name in zip([None, *names], names, strict=False) if name not in (None, before)]


def test_every_part_is_used(tmp_path):
    summary = run_session(CONFIG, SessionOptions(tmp_path), kind=OwnSession)
    looked = targets(tmp_path)
    assert looked[::2] == ["green"] * len(looked[::2]) and len(looked) > 4
    assert summary["gaze_shifts"] > 3
    learned = np.load(tmp_path / "weights.npz")
    assert learned["learner"].shape == (2, 2) and learned["learner"].any()
    assert np.abs(learned["som_weights"]).max() > 1000


def test_a_stopped_run_goes_on_with_them(tmp_path):
    def interrupt(session):
        if session.frame == 900:
            signal.raise_signal(signal.SIGINT)

    run_session(CONFIG, SessionOptions(tmp_path / "straight"), kind=OwnSession)
    with pytest.raises(KeyboardInterrupt):
        run_session(CONFIG, SessionOptions(tmp_path / "on"), interrupt, kind=OwnSession)
    with pytest.raises(CheckpointError, match="does not belong into a checkpoint"):
        run_session(CONFIG, SessionOptions(tmp_path / "on", resume=True))
    run_session(CONFIG, SessionOptions(tmp_path / "on", resume=True), kind=OwnSession)
    for name in ("frames.parquet", "gaze_shifts.parquet"):
        assert (tmp_path / "on" / name).read_bytes() == (tmp_path / "straight" / name).read_bytes()


def test_the_film_of_a_robot_without_activations(tmp_path):
    """What the learner reads is no map; the panel leaves it dark."""
    from jointattn_mj.gaze_following.film.panels import Box, MapPanel

    session = OwnSession(CONFIG)
    session.begin()
    while session.robot.shift is None or session.robot.shift.activations is None:
        session.step()
    MapPanel(np.zeros((400, 400, 3), np.uint8), Box(0, 0, 300, 380)).draw(np.zeros((400, 400, 3), np.uint8), session)
    session.close()


class ByTurns:
    """An attention model that looks at one candidate after the other, and says of itself what it is given."""

    def __init__(self, objects, saliency, motion, interest):
        self.saliency, self.motion, self.interest = saliency, motion, interest
        self.objects, self.frames = objects, 0

    def advance(self, attended, moves):
        pass

    def settle(self):
        pass

    def consider(self, visible):
        self.frames += 1
        return self.frames // 20 % (self.objects + 1) if self.frames % 20 == 0 else None


def session_by_turns(saliency, motion, interest):
    class Session(SessionRun):
        def new_robot(self, perceiver, seed):
            robot = super().new_robot(perceiver, seed)
            robot.attention = ByTurns(robot.face, saliency, motion, interest)
            return robot

    return Session(replace(CONFIG, minutes=0.1))


WEIGHTS = np.arange(5.0)


@pytest.mark.parametrize(
    "given",
    [
        (WEIGHTS.tolist(), WEIGHTS.astype(np.float32), np.zeros(5, int)),
        (np.stack([WEIGHTS, WEIGHTS], 1)[:, 0], tuple(WEIGHTS), 0.0),
    ],
)
def test_attention_is_logged_whatever_its_numbers_come_in(given):
    session = session_by_turns(*given)
    session.finish()
    assert session.frames.frames == session.total
    for candidate, weight in enumerate(WEIGHTS):
        assert (session.frames.column("saliency", candidate) == weight).all()
        assert (session.frames.column("motion", candidate) == weight).all()
        assert (session.frames.column("interest", candidate) == 0).all()


@pytest.mark.parametrize("wrong", [WEIGHTS[:4].tolist(), np.zeros(6), ["a"] * 5, [[0.0], [1.0]]])
def test_attention_without_a_number_for_each_candidate(wrong):
    with pytest.raises(ObservationError, match="expected a number for each of the 5 candidates, red, "):
        session_by_turns(WEIGHTS, WEIGHTS, wrong).finish()
