"""The agent of chapter 6: attention selector, visual feedback, gate and online contingency learning (Fig. 6.2)."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.gaze_following.attention import Attention, AttentionConfig, AttentionSelector
from jointattn_mj.gaze_following.fixation import attend
from jointattn_mj.gaze_following.gate import GazeConfig, HeadShift, gate_probability
from jointattn_mj.gaze_following.learners import LearnerConfig, Locations, make_learner
from jointattn_mj.io.progress import count
from jointattn_mj.options import Checked, Real, Whole
from jointattn_mj.perception.mean_face import MeanFace, MeanFaceConfig
from jointattn_mj.perception.percept import FaceAt, Observation, Perceiver, Percept
from jointattn_mj.perception.som import IMAGE_DIMENSION, SOM, SOMConfig, whole_number
from jointattn_mj.scene.camera import direction_of, off_centre

TIE = 1e-9
"""Scores of objects that differ by less are equal: they come from sums of hundreds of numbers."""


@dataclass(frozen=True)
class FamiliariseConfig(Checked):
    """Familiarisation with the caregiver's face before the session (section 6.4.1, "within three minutes")."""

    minutes: Annotated[float, Real("(0, 1e6]")] = 3.0
    """Simulated minutes for which the robot looks at the face and learns its patterns."""
    every: Annotated[int, Whole("[1, 1e6]")] = 3
    """Learn a face pattern every N frames; ten patterns a second show all that thirty would."""


@dataclass(frozen=True)
class RobotConfig(Checked):
    """Settings of the agent: attention, gaze shifts, learning."""

    attention: AttentionConfig = field(default_factory=AttentionConfig)
    """Attention selector: where and when to look (6.3.2)."""
    gaze: GazeConfig = field(default_factory=GazeConfig)
    """Gate and head movement (6.3.1, 6.4.1)."""
    learner: LearnerConfig = field(default_factory=LearnerConfig)
    """The online contingency learning module (6.3.3)."""
    som: SOMConfig = field(default_factory=SOMConfig)
    """The self-organising map of face patterns (6.3.3, 6.4.1)."""
    face_at: FaceAt = "found"
    """Where in the image the face pattern is cut out: where the face was found, or where the head is remembered to be.
    The face is found by its features. These move when the head turns, and a pattern that is cut out around them does
    not show that they have moved. A face far from where it is remembered is cut out where it was found, and so is
    every face at a video and before a camera: people's heads do not stay where they were."""
    mean_face: MeanFaceConfig = field(default_factory=MeanFaceConfig)
    """Faces as deviations from this person's mean, so that what was learned serves for other people."""
    familiarise: FamiliariseConfig = field(default_factory=FamiliariseConfig)
    """The minutes before the session in which the map is learned (6.4.1)."""

    def __post_init__(self) -> None:
        super().__post_init__()
        gaze, code = self.gaze, self.learner.code
        if gaze.gate == "certainty" and (gaze.commands != "object" or code != "cross_situational"):
            raise ConfigError(
                "gaze.gate certainty needs gaze.commands object and learner.code cross_situational, whose evidence for "
                f"an object is a probability; got {gaze.commands} and {code}"
            )
        if gaze.read_again and not gaze.feedback_frames:
            raise ConfigError("gaze.read_again needs gaze.feedback_frames, the frames at which it reads; got none")


@dataclass
class GazeShift:
    """One gaze shift, as the robot knows it.

    Candidates are numbered as in ``Percept``; directions are (pan, tilt) in degrees.
    """

    source: int | None  # candidate attended before
    chosen: int  # candidate that attention chose
    by_learner: bool  # whether the learner's suggestion was commanded
    start: np.ndarray  # (2,) head at launch
    command: np.ndarray  # (2,) direction commanded
    suggestion: np.ndarray | None  # (2,) direction to which the learner's map leads; only from the face
    activations: np.ndarray | None  # of the map for the face at launch; only from the face
    in_view: np.ndarray | None  # (k, 2) turns from the face to the objects in view at launch; only from the face
    source_direction: np.ndarray | None  # (2,) of the source at launch, if it was visible
    aim: int | None = None  # candidate that the command leads to; None for a bare direction
    reached: int | None = None  # candidate at the centre of view after landing
    learned: bool = False  # whether the shift gave the learner a pair


class GazeFollower:
    """Agent that learns to look where the caregiver looks; maps observations to desired head angles.

    An observation has an ``image`` (uint8, read only when the robot perceives), ``head_angles`` (pan
    and tilt, rad) and ``head_moves`` (bool). The action is the desired pan and tilt, rad.

    Attributes:
        face: Number of the candidate that is the face; objects come before it.
        attention: Attention selector.
        som: Self-organising map of face patterns.
        mean_face: Mean and spread of the face patterns, if they are coded as deviations from the mean; else None.
        learner: Maps a face to the motor command that leads from it to the object.
        attended: Candidate that is fixated, or None.
        percept: Percept of this frame; None while the head turns.
        shift: Gaze shift under way, or None.
        landed: Gaze shift that ended in this frame, or None.
        iterations: Learning iterations so far, l of eq. 6.8.
    """

    def __init__(self, config: RobotConfig, perceiver: Perceiver, objects: int, seed: np.random.SeedSequence):
        """Make an agent that has learned nothing.

        Args:
            config: Its settings.
            perceiver: Makes percepts of observations.
            objects: Number of objects, n; the face is candidate n.
            seed: Of the agent's random draws.
        """
        attention, gate, som, learner = (np.random.default_rng(child) for child in seed.spawn(4))
        self.config, self.perceiver = config, perceiver
        self.face = objects
        self.attention: Attention = AttentionSelector(config.attention, objects, attention)
        subtracted = config.mean_face.subtracted and perceiver.pattern_size >= IMAGE_DIMENSION
        self.som = SOM(perceiver.pattern_size, config.som, som, standardises=not subtracted)
        self.mean_face = MeanFace(perceiver.pattern_size, config.mean_face) if subtracted else None
        self.learner = make_learner(config.learner, len(self.som.weights), learner)
        self.iterations = 0
        self.attended: int | None = None
        self.percept: Percept | None = None
        self.shift: GazeShift | None = None
        self.landed: GazeShift | None = None
        self._gate = gate
        self._scores: np.ndarray | None = None  # of the objects in view when the face was last left
        self._leaving_for: int | None = None  # chosen candidate, while the robot waits for the face to be still
        self._movement: HeadShift | None = None
        self._held = np.zeros(2)  # reference of the head's servos, deg
        self._command = np.zeros(2)  # the same in rad

    def __repr__(self) -> str:
        """In one line: what is attended, and how much was learned."""
        attended = {None: "nothing", self.face: "the face"}.get(self.attended, f"object {self.attended}")
        return f"GazeFollower(attends to {attended}, {count(self.iterations, 'learning iteration')})"

    def familiarise(self, observation: Observation, frame: int) -> np.ndarray:
        """Action (2,) for one frame before the session: look at the face, and learn its patterns.

        Args:
            observation: See the class.
            frame: Number of the frame, from 0; one in ``config.familiarise.every`` is perceived.
        """
        head = np.degrees(observation.head_angles)
        if frame % self.config.familiarise.every == 0:
            percept = self.perceiver.perceive(observation, landed=True)
            if percept.visible[self.face]:
                self._hold(direction_of(percept.px[self.face], head))
                if self.mean_face is not None:
                    self.mean_face.update(self.perceiver.face_pattern())
                self.som.update(self._coded_face())
        self.attended = self.face
        return self._command

    def act(self, observation: Observation) -> np.ndarray:
        """Action (2,), rad, for one frame of the session: perceive, attend, and shift gaze."""
        self.landed = self.percept = None
        shift, movement = self.shift, self._movement
        if shift is not None and movement is not None and (observation.head_moves or not movement.commanded):
            return self._turn(shift, movement, observation)
        self.percept = percept = self.perceiver.perceive(observation, shift is not None)
        if shift is not None:
            self._land(shift, percept, np.degrees(observation.head_angles))
        if self.mean_face is not None and self.attended == self.face and percept.visible[self.face]:
            self.mean_face.look(self.perceiver.face_pattern)
        chosen = self._choose(percept, fixating=shift is None)
        if chosen is not None:
            self._launch(chosen, percept, np.degrees(observation.head_angles))
        return self._command

    @property
    def frames_on_way(self) -> int:
        """How many of the coming frames pass on the way of a gaze shift before its aim may change, or it is over."""
        movement = self._movement
        return 0 if movement is None else movement.frames_before(self.config.gaze.feedback_frames)

    def commanded_after(self, frames: int) -> bool:
        """Whether after so many frames on the way of a gaze shift only its end is held until the head stands still."""
        return self._movement is not None and self._movement.frame + frames >= self._movement.frames

    @property
    def waits(self) -> bool:
        """Whether attention has chosen a candidate, and the robot waits for the face to be still."""
        return self._leaving_for is not None

    def coming(self, frames: int) -> np.ndarray:
        """References (frames, 2) of the head's servos, deg, in as many frames without a decision."""
        return np.repeat(self._held[None], frames, axis=0) if self._movement is None else self._movement.coming(frames)

    def pass_by(self, references: np.ndarray) -> None:
        """Let as many frames without a decision pass, in which the ``references`` (k, 2), deg, are commanded."""
        self.landed = self.percept = None
        if self._movement is not None:
            self._movement.pass_by(len(references))
            self._hold(references[-1])

    @property
    def gate_probability(self) -> float:
        """Probability that the learner commands a shift from the face now; with gate certainty, at the last one."""
        return gate_probability(self.config.gaze, self.iterations, self._scores)

    def face_input(self) -> np.ndarray:
        """Activations (k,) of the map for the face in the last percept: the learner's input."""
        return self.som.activations(self._coded_face())

    def _coded_face(self) -> np.ndarray:
        """The face pattern of the last percept, as the map takes it."""
        pattern = self.perceiver.face_pattern()
        return pattern if self.mean_face is None else self.mean_face.deviation(pattern)

    def _choose(self, percept: Percept, fixating: bool) -> int | None:
        """The candidate to which the gaze shifts in this frame; None if it stays, or waits for the face to be still.

        Args:
            percept: Of this frame.
            fixating: False in the frame in which a gaze shift ends.
        """
        chosen = self._leaving_for
        if chosen is None:
            chosen = attend(self.attention, self.attended, percept, fixating)
        else:
            self.attention.advance(self.attended, percept.moves)
        waits = self.config.gaze.wait_for_still_face and self.attended == self.face and percept.moves[self.face]
        self._leaving_for = chosen if waits else None
        return chosen if not waits and chosen is not None and percept.visible[chosen] else None

    def hold(self, direction: np.ndarray) -> None:
        """Turn to ``direction`` (2,), deg, and stay there; only while no gaze shift is under way."""
        self._hold(direction)

    def _hold(self, direction: np.ndarray) -> None:
        """Make ``direction`` (2,), deg, the reference of the head's servos."""
        self._held, self._command = direction, np.radians(direction)

    def _launch(self, chosen: int, percept: Percept, head: np.ndarray) -> None:
        """Begin a gaze shift; from the face to an object, the gate decides who commands it (eq. 6.8).

        Args:
            chosen: Candidate that attention chose.
            percept: Of this frame.
            head: Direction of the head (2,), deg.
        """
        source = self.attended
        aim: int | None = chosen
        command = direction_of(percept.px[chosen], head)
        suggestion = activations = in_view = None
        by_learner = False
        if source == self.face and percept.visible[self.face]:
            activations, in_view = self.face_input(), self._in_view(percept, head)
            suggestion = head + self.learner.predict(activations)
            goal, best = self._goal(activations, in_view, percept, head, origin=head)
            if self._gate.random() < self.gate_probability and goal is not None:
                by_learner, command, aim = True, goal, best
        source_visible = source is not None and percept.visible[source]
        self.shift = GazeShift(
            source=source,
            chosen=chosen,
            by_learner=by_learner,
            start=head,
            command=command,
            suggestion=suggestion,
            activations=activations,
            in_view=in_view,
            source_direction=direction_of(percept.px[source], head) if source_visible else None,
            aim=aim,
        )
        self._movement = HeadShift(self._held, command, self.config.gaze.shift_frames)
        self._hold(self._movement.next_reference())

    def _goal(
        self, activations: np.ndarray, in_view: np.ndarray, percept: Percept, head: np.ndarray, origin: np.ndarray
    ) -> tuple[np.ndarray | None, int | None]:
        """What the learner commands for a face: a direction (2,), deg, and the object there, if it commands objects.

        Both are None where there is no object to command, or no evidence for one rather than another.

        Args:
            activations: Of the map for the face, (k,).
            in_view: Turns from the face to the objects in view, (n, 2), deg.
            percept: Of this frame.
            head: Direction of the head (2,), deg.
            origin: Direction (2,) from which a learned turn is counted, deg.
        """
        if self.config.gaze.commands == "direction":
            return origin + self.learner.predict(activations), None
        self._scores = scores = self.learner.score(activations, Locations(in_view))
        if not len(scores) or (len(scores) > 1 and np.ptp(scores) < TIE):
            return None, None
        best = int(np.flatnonzero(percept.visible[: self.face])[np.argmax(scores)])
        return direction_of(percept.px[best], head), best

    def _in_view(self, percept: Percept, head: np.ndarray) -> np.ndarray:
        """Turns (k, 2), deg, that lead from the face of a percept, with the head at ``head``, to its k objects."""
        face = direction_of(percept.px[self.face], head)
        visible = np.flatnonzero(percept.visible[: self.face])
        return np.array([direction_of(percept.px[number], head) - face for number in visible]).reshape(-1, 2)

    def _turn(self, shift: GazeShift, movement: HeadShift, observation: Observation) -> np.ndarray:
        """Action (2,), rad, for one frame of a gaze shift; its aim is corrected on the way.

        Args:
            shift: The gaze shift.
            movement: The head's movement.
            observation: See the class.
        """
        gaze = self.config.gaze
        reads = gaze.read_again and shift.by_learner
        perceives = movement.frame in gaze.feedback_frames and not movement.commanded
        if perceives and (reads or shift.aim not in (None, self.face)):
            percept = self.perceiver.perceive(observation, landed=True)
            goal, shift.aim = self._corrected(shift, percept, np.degrees(observation.head_angles))
            if goal is not None:
                shift.command = goal
                movement.aim(goal)
        self._hold(movement.next_reference())
        return self._command

    def _corrected(self, shift: GazeShift, percept: Percept, head: np.ndarray) -> tuple[np.ndarray | None, int | None]:
        """Direction (2,), deg, and candidate to aim at from now on: by the face, if it is read again, or by the object.

        The direction is None where neither is visible.

        Args:
            shift: The gaze shift.
            percept: Of this frame.
            head: Direction of the head (2,), deg.
        """
        if self.config.gaze.read_again and shift.by_learner and percept.visible[self.face]:
            face = direction_of(percept.px[self.face], head)
            goal, best = self._goal(self.face_input(), self._in_view(percept, head), percept, head, origin=face)
            if goal is not None:
                return goal, best
        if shift.aim is None or not percept.visible[shift.aim]:
            return None, shift.aim
        return direction_of(percept.px[shift.aim], head), shift.aim

    def _land(self, shift: GazeShift, percept: Percept, head: np.ndarray) -> None:
        """End a gaze shift: attend to the candidate nearest to the centre of view, and learn from the shift.

        Args:
            shift: The gaze shift.
            percept: Of this frame.
            head: Direction of the head (2,), deg.
        """
        nearest, distance = self._nearest(percept, head)
        centred = distance <= self.config.gaze.centre_radius_deg
        shift.reached = nearest if centred else None
        self.attended = nearest if centred or self.config.gaze.attends == "nearest" else None
        self._learn(shift, percept, head)
        self.landed, self.shift, self._movement = shift, None, None
        self.attention.settle()

    @staticmethod
    def _nearest(percept: Percept, head: np.ndarray) -> tuple[int | None, float]:
        """The visible candidate nearest to the centre of view, and its distance (deg); None and inf without one."""
        if not percept.visible.any():
            return None, np.inf
        distances = [
            off_centre(direction_of(pixel, head), head) if visible else np.inf
            for pixel, visible in zip(percept.px, percept.visible, strict=True)
        ]
        nearest = int(np.argmin(distances))
        return nearest, distances[nearest]

    def _learn(self, shift: GazeShift, percept: Percept, head: np.ndarray) -> None:
        """Learn from the face that a shift left or reached, and from the object at its other end (section 6.3.1).

        Args:
            shift: The gaze shift, which has reached its end.
            percept: Of this frame.
            head: Direction of the head (2,), deg.
        """
        config = self.config.learner
        centred = config.reference == "object"
        if shift.activations is not None and shift.in_view is not None:
            reached = None
            if shift.reached not in (None, self.face):
                end = direction_of(percept.px[shift.reached], head) if centred else head
                reached = end - shift.start
                self.iterations += 1
            if reached is not None or config.uses_all_looks:
                self._pair(shift, shift.activations, Locations(shift.in_view, reached))
        if config.directions == "both" and shift.reached == self.face:
            reached = None
            if shift.source_direction is not None and shift.source != self.face:
                reached = (shift.source_direction if centred else shift.start) - head
                self.iterations += config.counts == "both"
            if reached is not None or config.uses_all_looks:
                self._pair(shift, self.face_input(), Locations(self._in_view(percept, head), reached))

    def _pair(self, shift: GazeShift, face: np.ndarray, locations: Locations) -> None:
        """Let the learner learn from a face and the locations of objects.

        Args:
            shift: The gaze shift that gives them.
            face: Activations of the map for it, (k,).
            locations: Where objects lay.
        """
        self.learner.learn(face, locations)
        pairs_all = self.config.learner.pairs == "in_view" and len(locations.in_view) > 0
        shift.learned |= locations.reached is not None or pairs_all

    def weights(self) -> dict[str, np.ndarray]:
        """All that was learned, by name: the map of faces, the learner's weights, and l of eq. 6.8."""
        return {
            **{f"som_{name}": array for name, array in self.som.arrays().items()},
            **({} if self.mean_face is None else self.mean_face.arrays()),
            "learner": self.learner.weights(),
            "iterations": np.array(self.iterations),
        }

    def load(self, weights: Mapping[str, np.ndarray]) -> None:
        """Take over what another agent's ``weights`` gave, in place of familiarisation.

        Raises:
            ConfigError: The arrays do not fit this robot's config.
        """
        source = "give the weights.npz of a finished session with this config"
        try:
            arrays = {name: weights[f"som_{name}"] for name in self.som.arrays()}
            som = SOM.from_arrays(arrays, self.config.som, self.som.standardises)
            size = self.perceiver.pattern_size
            if som.weights.shape[1] != size:
                raise ConfigError(f"a map of faces of {size} numbers each is needed; got {som.weights.shape[1]}")
            iterations = whole_number("iterations", weights["iterations"])
            mean_face = self._known_mean_face(weights)
            self.learner.load(weights["learner"])
            self.som, self.iterations, self.mean_face = som, iterations, mean_face
        except KeyError as error:
            raise ConfigError(f"these weights lack {error}; {source}") from error
        except (ValueError, TypeError, IndexError) as error:
            raise ConfigError(f"these weights do not fit ({error}); {source}") from error

    def _known_mean_face(self, weights: Mapping[str, np.ndarray]) -> MeanFace | None:
        """Mean and spread of faces to begin with, if this robot subtracts a mean face."""
        if self.mean_face is None:
            if "mean_face" in weights:
                raise ConfigError("their units hold deviations from a mean face, which is not subtracted here")
            return None
        if "mean_face" not in weights:
            raise ConfigError("their units hold faces as they are, and here deviations from a mean face are needed")
        mean = MeanFace.from_arrays(weights, self.config.mean_face)
        if len(mean.mean) != self.perceiver.pattern_size:
            raise ConfigError(f"a mean face of {self.perceiver.pattern_size} numbers is needed; got {len(mean.mean)}")
        return mean
