"""The preliminary run from which the dissertation set its gate (section 6.4.1, Fig. 6.7): synchronised gaze shifts.

"We performed preliminary experiments to determine the parameters of the gate in an environment where the robot could
learn most easily, that is, the timing of gaze shift between the human and the robot is synchronized completely."

World, robot, map of faces and learner are those of a session; only the times of gaze shifts are given. The robot waits
at the face. When the caregiver's gaze comes to rest on an object, the robot shifts to an object that visual feedback
chooses by eq. 6.7 (the gate is shut), and back to the face while the caregiver's gaze still rests. Both directions of
shift give pairs in which the face and its gaze target belong together. Whether the object reached is the right one is
left to chance and interest, as in a session.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from jointattn_mj.gaze_following.agent import GazeFollower
from jointattn_mj.gaze_following.attention import AttentionConfig, AttentionSelector
from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.scene.camera import directions_to, off_centre
from jointattn_mj.scene.caregiver import Phase
from jointattn_mj.scene.layout import Layout
from jointattn_mj.scene.model import HEAD_POSITION, rest_height
from jointattn_mj.scene.movement import gaze_angles
from jointattn_mj.scene.world import WorldConfig

RESTS = (Phase.OBSERVE, Phase.GAZE)
"""When the caregiver's gaze rests: on the object in the hand, and on the one just put down; two seconds each."""
DWELL_FRAMES = 3
"""Frames of fixation before the shift back; two shifts of 27 frames then fit into two seconds."""


class ToldSelector(AttentionSelector):
    """Attention selector that shifts when it is told to; draws the object by eq. 6.7.

    Attributes:
        told: Whether the caregiver's gaze has come to rest and the robot has not shifted since.
    """

    def __init__(self, config: AttentionConfig, objects: int, rng: np.random.Generator):
        super().__init__(config, objects, rng)
        self.told = False
        self._attended: int | None = objects
        self._dwell = 0

    def advance(self, attended: int | None, moves: np.ndarray) -> None:
        """See ``AttentionSelector``; and remember where the robot looks."""
        self._dwell = self._dwell + 1 if attended == self._attended else 1
        self._attended = attended
        super().advance(attended, moves)

    def draw(self, visible: np.ndarray) -> int | None:
        """From the face: an object, once, when told. From elsewhere: the face, after ``DWELL_FRAMES``."""
        if self._attended != self.face:
            return self.face if self._dwell >= DWELL_FRAMES else None
        objects = visible & (np.arange(len(visible)) != self.face)
        if not self.told or not objects.any():
            return None
        self.told = False
        return super().draw(objects)


class SynchronisedSession(SessionRun):
    """A session with synchronised gaze shifts; ``synchronised`` makes a fitting config."""

    def __init__(self, config: SessionConfig):
        super().__init__(config)
        rng = np.random.default_rng(np.random.SeedSequence(config.seed).spawn(4)[3])
        self.robot.attention = self.selector = ToldSelector(config.robot.attention, self.robot.face, rng)
        self._phase = self.world.caregiver.phase

    def begin(self) -> None:
        """See ``SessionRun``; the first shift comes when the caregiver's gaze comes to rest the next time."""
        super().begin()
        self._phase = self.world.caregiver.phase

    def step(self, watch: Callable[[SessionRun], object] | None = None) -> None:
        """One frame; afterwards the robot may be told."""
        super().step(watch)
        phase = self.world.caregiver.phase
        if phase != self._phase:
            self.selector.told = phase in RESTS
        self._phase = phase


def synchronised(config: SessionConfig) -> SessionConfig:
    """``config`` with the gate shut, a caregiver without jitter of durations, and possible shifts in every frame."""
    return replace(
        config,
        world=replace(config.world, behaviour=replace(config.world.behaviour, duration_jitter=0.0)),
        robot=replace(
            config.robot,
            attention=replace(config.robot.attention, selection_period=1),
            gaze=replace(config.robot.gaze, gate="shut"),
        ),
    )


class Gazes:
    """Test gazes: layouts of objects, and the caregiver's head turned to one of the objects.

    Only objects on the table are gaze targets; an object in the hand is always at the same place.
    """

    def __init__(self, config: WorldConfig, count: int, pattern_noise_deg: float, rng: np.random.Generator):
        """Draw test gazes.

        Args:
            config: Scene, layout and behaviour.
            count: How many gazes.
            pattern_noise_deg: Noise of the face pattern (``StateConfig``), degrees.
            rng: For all of them.
        """
        objects = len(config.scene.objects)
        layout = Layout(config.layout, rng)
        points = np.array([
            np.column_stack([layout.fill(objects), np.full(objects, rest_height(config.scene))]) for _ in range(count)
        ])  # fmt: skip
        self.targets = rng.integers(objects, size=count)
        self.directions = directions_to(points.reshape(-1, 3)).reshape(count, objects, 2)
        own = (points[np.arange(count), self.targets] - HEAD_POSITION) * (-1.0, -1.0, 1.0)
        self.patterns = config.behaviour.head_share * np.degrees(gaze_angles(np.zeros(3), own))
        self.patterns += pattern_noise_deg * rng.standard_normal(self.patterns.shape)

    def test(self, robot: GazeFollower) -> tuple[float, float]:
        """Share of gazes whose target is nearest to the learner's suggestion, and the median error, deg."""
        start = directions_to(np.array([HEAD_POSITION]))[0]
        right, error = [], []
        for pattern, directions, target in zip(self.patterns, self.directions, self.targets, strict=True):
            suggestion = start + robot.learner.predict(robot.som.activations(pattern))
            off = [off_centre(direction, suggestion) for direction in directions]
            right.append(int(np.argmin(off)) == target)
            error.append(off[target])
        return float(np.mean(right)), float(np.median(error))
