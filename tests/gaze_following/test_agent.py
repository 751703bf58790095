"""The robot of Fig. 6.2 in a world made by hand: what it attends to, what it commands, and what it learns from."""

from dataclasses import replace
from itertools import cycle

import numpy as np
import pytest

from jointattn_mj.errors import ConfigError
from jointattn_mj.gaze_following.agent import FamiliariseConfig, GazeFollower, RobotConfig
from jointattn_mj.gaze_following.attention import AttentionConfig
from jointattn_mj.gaze_following.gate import GazeConfig
from jointattn_mj.gaze_following.learners import LearnerConfig, Locations
from jointattn_mj.perception.mean_face import MeanFaceConfig
from jointattn_mj.perception.percept import Percept, StillObservation
from jointattn_mj.scene.camera import in_image, pixel_of

RED, BLUE, FACE = 0, 1, 2
LOCATIONS = ((8.0, -10.0), (-8.0, -12.0), (0.0, 3.0))
SETTLING = 2
NO_IMAGE = np.zeros((0, 0, 3), np.uint8)


class Scene:
    """Things in directions (n + 1, 2); a head that does at once as it is told, and counts as moving a little longer."""

    pattern_size = 2

    def __init__(self, locations=LOCATIONS):
        self.locations = np.array(locations, float)
        self.head = np.zeros(2)
        self.moves = np.zeros(len(locations), bool)
        self.hidden: set[int] = set()
        self.face = np.zeros(2)
        self.looks: list[bool] = []
        self._still = SETTLING

    def perceive(self, observation, landed: bool) -> Percept:
        self.looks.append(landed)
        head = np.degrees(observation.head_angles)
        px = np.array([pixel_of(location, head) for location in self.locations])
        visible = in_image(px) & ~np.isin(np.arange(len(px)), list(self.hidden))
        return Percept(visible=visible, px=np.where(visible[:, None], px, np.nan), moves=self.moves & visible)

    def face_pattern(self) -> np.ndarray:
        return self.face.copy()

    def frame(self, robot: GazeFollower) -> np.ndarray:
        """One frame of robot and head."""
        observation = StillObservation(NO_IMAGE, np.radians(self.head), self._still < SETTLING)
        command = np.degrees(robot.act(observation))
        self._still = self._still + 1 if np.allclose(command, self.head, atol=1e-9) else 0
        self.head = command
        return command


class Wants:
    """Draws what a test wants, over and over, instead of by eq. 6.7."""

    def __init__(self, *wanted: int):
        self._wanted = cycle(wanted)

    def __call__(self, visible: np.ndarray) -> int:
        return next(self._wanted)


def make(scene: Scene, *wanted: int, gaze=None, learner=None, attention=None) -> GazeFollower:
    config = RobotConfig(
        gaze=GazeConfig(**(gaze or {"gate": "shut"})),
        learner=LearnerConfig(**(learner or {})),
        attention=AttentionConfig(**(attention or {})),
    )
    robot = GazeFollower(config, scene, 2, np.random.SeedSequence(0))
    robot.som.weights[:] = np.stack(np.meshgrid(np.linspace(-30, 30, 9), np.linspace(-5, 30, 9)), -1).reshape(81, 2)
    if wanted:
        robot.attention.draw = Wants(*wanted)
    return robot


def advance(robot: GazeFollower, scene: Scene, shifts: int, watch=None) -> list:
    """Live until so many shifts have landed."""
    landed = []
    for _ in range(400 * shifts):
        scene.frame(robot)
        if watch is not None:
            watch()
        if robot.landed is not None:
            landed.append(robot.landed)
        if len(landed) == shifts:
            return landed
    raise AssertionError(f"only {len(landed)} shifts landed")


def pairs_of(robot: GazeFollower) -> list[tuple[np.ndarray, np.ndarray]]:
    """The pairs that the learner will be given from now on."""
    pairs, learn = [], robot.learner.learn

    def keep(face, locations):
        pairs.append((face.copy(), locations.reached.copy()))
        learn(face, locations)

    robot.learner.learn = keep
    return pairs


def test_a_shift_takes_its_frames_and_the_draws_their_period():
    scene = Scene()
    robot = make(scene, FACE, RED)
    launches, landings, frame = [], [], 0
    turning = False
    while len(landings) < 2:
        scene.frame(robot)
        if robot.landed is not None:
            landings.append(frame)
        if robot.shift is not None and not turning:
            launches.append(frame)
        turning = robot.shift is not None
        frame += 1
    assert launches == [17, landings[0] + 17]  # the 18th frame of dwell, the landing's own being the first
    assert [b - a for a, b in zip(launches, landings, strict=True)] == [26 + SETTLING] * 2
    np.testing.assert_allclose(scene.head, LOCATIONS[RED], atol=1e-6)


def test_nothing_is_perceived_or_counted_while_the_head_turns():
    """Fig. 6.3b: interest does not change between fixations; feedback alone looks, once a shift to an object."""
    scene = Scene()
    scene.moves[:] = True
    robot = make(scene, FACE, RED)
    advance(robot, scene, 1)
    while robot.shift is None:
        scene.frame(robot)
    kept, looks = robot.attention.saliency.copy(), len(scene.looks)
    while robot.shift is not None:
        scene.frame(robot)
        assert (robot.percept is None) == (robot.landed is None)
        np.testing.assert_array_equal(robot.attention.saliency, kept)
        assert (robot.attention.motion == 18 + 17).all()  # two fixations of 18 frames, less the frame of landing
    assert robot.landed is not None
    assert robot.percept is not None
    assert scene.looks[looks:] == [True, True]  # feedback while turning to red, and the landing


def test_motion_cues_draw_attention():
    """What moved for 40 frames is drawn with chance 5.5 * 800 / (5.5 * 800 + 800 + 1500), and else with 800 / 3100."""

    def share(cues: bool) -> float:
        config = RobotConfig(attention=AttentionConfig(motion_cues=cues, selection_period=40))
        chosen = []
        for seed in range(150):
            scene = Scene()
            scene.moves[BLUE] = True
            robot = GazeFollower(config, scene, 2, np.random.SeedSequence(seed))
            for _ in range(40):
                scene.frame(robot)
            chosen.append(robot.shift.chosen)
        return float(np.mean(np.array(chosen) == BLUE))

    assert share(True) == pytest.approx(0.657, abs=0.12)
    assert share(False) == pytest.approx(0.258, abs=0.12)


def test_pair_from_the_face_to_an_object():
    """The face before, and the command that would have centred the object from there (section 6.3.1)."""
    scene = Scene()
    robot = make(scene, FACE, RED)
    pairs = pairs_of(robot)
    scene.face = np.array([20.0, 10.0])
    advance(robot, scene, 1)
    expected = robot.som.activations(scene.face)

    def turn_away():
        if robot.shift is not None:
            scene.face = np.array([-20.0, 0.0])  # the caregiver looks elsewhere while the robot turns

    shift = advance(robot, scene, 1, turn_away)[0]
    assert (shift.source, shift.chosen, shift.reached, shift.by_learner, shift.learned) == (FACE, RED, RED, False, True)
    [(activations, command)] = pairs
    np.testing.assert_array_equal(activations, expected)
    np.testing.assert_allclose(command, np.subtract(LOCATIONS[RED], LOCATIONS[FACE]), atol=1e-6)
    assert robot.iterations == 1


@pytest.mark.parametrize(
    ("learner", "pairs_expected", "iterations"),
    [({}, 1, 0), ({"counts": "both"}, 1, 1), ({"directions": "face_to_object"}, 0, 0)],
)
def test_pair_from_an_object_to_the_face(learner, pairs_expected, iterations):
    """The face after, and where the object was when the robot left it: carried on, it is where it was no more."""
    scene = Scene()
    robot = make(scene, RED, FACE, learner=learner)
    advance(robot, scene, 1)
    pairs = pairs_of(robot)
    left_at = np.array([6.0, -9.0])

    def carry():
        scene.locations[RED] = left_at if robot.shift is None else (-3.0, -5.0)
        scene.face = np.array([0.0, 10.0]) if robot.shift is None else np.array([25.0, 20.0])

    scene.locations[RED] = left_at
    shift = advance(robot, scene, 1, carry)[0]
    assert (shift.source, shift.reached, shift.learned) == (RED, FACE, bool(pairs_expected))
    assert len(pairs) == pairs_expected
    assert robot.iterations == iterations
    for activations, command in pairs:
        np.testing.assert_allclose(command, left_at - LOCATIONS[FACE], atol=1e-6)
        np.testing.assert_array_equal(activations, robot.som.activations(np.array([25.0, 20.0])))


def test_from_object_to_object_nothing_is_learned():
    scene = Scene()
    robot = make(scene, RED, BLUE)
    pairs = pairs_of(robot)
    assert [shift.learned for shift in advance(robot, scene, 2)] == [False, False]
    assert not pairs


def test_executed_command_as_reference():
    """The head's own turn, whether or not it centred the object exactly."""
    scene = Scene()
    robot = make(scene, FACE, RED, learner={"reference": "executed"}, gaze={"gate": "shut", "feedback_frames": ()})
    pairs = pairs_of(robot)
    advance(robot, scene, 1)

    def slip():
        if robot.shift is not None:
            scene.locations[RED] = np.add(LOCATIONS[RED], (2.0, 0.0))  # still within the centre's radius

    advance(robot, scene, 1, slip)
    np.testing.assert_allclose(pairs[0][1], np.subtract(LOCATIONS[RED], LOCATIONS[FACE]), atol=1e-6)


def carried_away(feedback_frames: tuple[int, ...], shift_frames: int = 26):
    """A shift to red, which is carried to and fro meanwhile."""
    scene = Scene()
    gaze = {"gate": "shut", "feedback_frames": feedback_frames, "shift_frames": shift_frames}
    robot = make(scene, FACE, RED, gaze=gaze)
    advance(robot, scene, 1)
    path = []

    def carry():
        if robot.shift is not None:
            scene.locations[RED] = (-2.0, -4.0)
        path.append(scene.head.copy())

    return robot, advance(robot, scene, 1, carry)[0], np.array(path)


def test_visual_feedback_corrects_on_the_way():
    robot, shift, path = carried_away((17,))
    assert shift.reached == RED
    np.testing.assert_allclose(path[-1], (-2, -4), atol=1e-6)
    assert np.abs(np.diff(path, axis=0)).max() < 3  # no jump
    robot, shift, path = carried_away(())
    assert shift.reached is None
    assert robot.iterations == 0
    np.testing.assert_allclose(path[-1], LOCATIONS[RED], atol=1e-6)


@pytest.mark.parametrize("frames", [(10,), (11, 12), (9, 10, 11, 12)])
def test_feedback_after_the_last_command_is_too_late(frames):
    _, _, path = carried_away(frames, shift_frames=10)
    assert np.isfinite(path).all()


def test_the_gate_lets_the_learner_command():
    scene = Scene()
    robot = make(scene, FACE, RED, RED, gaze={"gate": "open"})
    advance(robot, scene, 1)
    activations = robot.som.activations(scene.face)
    for _ in range(300):
        robot.learner.learn(activations, Locations.only(np.subtract(LOCATIONS[BLUE], LOCATIONS[FACE])))
    shift = advance(robot, scene, 1)[0]
    assert (shift.by_learner, shift.chosen, shift.reached) == (True, RED, BLUE)
    np.testing.assert_array_equal(shift.command, shift.suggestion)
    np.testing.assert_allclose(shift.command, LOCATIONS[BLUE], atol=0.5)
    back = advance(robot, scene, 1)[0]  # blue to red: no face, nobody to ask
    assert not back.by_learner
    assert back.suggestion is None


@pytest.mark.parametrize(("attends", "attended"), [("nearest", RED), ("centred", None)])
def test_landing_on_nothing(attends, attended):
    scene = Scene()
    robot = make(scene, FACE, RED, gaze={"gate": "open", "attends": attends})
    advance(robot, scene, 1)
    activations = robot.som.activations(scene.face)
    for _ in range(300):
        robot.learner.learn(activations, Locations.only([15.0, -13.0]))  # 7 degrees beside red
    shift = advance(robot, scene, 1)[0]
    assert shift.reached is None
    assert not shift.learned
    assert robot.attended == attended


def test_when_nothing_is_in_view():
    """It waits, and goes on when there is something again."""
    scene = Scene()
    robot = make(scene)
    scene.hidden = {RED, BLUE, FACE}
    for _ in range(60):
        np.testing.assert_array_equal(scene.frame(robot), [0, 0])
    scene.hidden = set()
    advance(robot, scene, 1)
    scene.hidden = {RED, BLUE, FACE}
    while robot.landed is None:  # lands blind if it has set out
        scene.frame(robot)
        if robot.shift is None:
            break
    scene.hidden = {FACE}
    advance(robot, scene, 1)


def test_familiarise():
    """The face in the centre of view, a pattern every third frame."""
    scene = Scene(((8.0, -10.0), (-8.0, -12.0), (5.0, 4.0)))
    robot = make(scene)
    for frame in range(30):
        observation = StillObservation(NO_IMAGE, np.radians(scene.head))
        scene.head = np.degrees(robot.familiarise(observation, frame))
    np.testing.assert_allclose(scene.head, (5, 4), atol=1e-6)
    assert robot.som.n_patterns == 10
    assert robot.attended == FACE
    with pytest.raises(ConfigError, match=r"FamiliariseConfig\.minutes"):
        FamiliariseConfig(minutes=0)


def test_same_seed_same_run():
    def runs(seed):
        scene = Scene()
        robot = GazeFollower(RobotConfig(), scene, 2, np.random.SeedSequence(seed))
        return [(shift.chosen, shift.by_learner) for shift in advance(robot, scene, 12)]

    assert runs(1) == runs(1) != runs(2)


class TestWeights:
    """What one robot learned, in another."""

    def learned(self) -> GazeFollower:
        scene = Scene()
        robot = make(scene, FACE, RED)
        advance(robot, scene, 8)
        return robot

    def test_round_trip(self):
        robot = self.learned()
        other = GazeFollower(robot.config, Scene(), 2, np.random.SeedSequence(9))
        other.load(robot.weights())
        assert other.iterations == robot.iterations > 0
        face = np.array([10.0, 5.0])
        np.testing.assert_array_equal(other.som.activations(face), robot.som.activations(face))
        activations = robot.som.activations(face)
        np.testing.assert_array_equal(other.learner.predict(activations), robot.learner.predict(activations))

    @pytest.mark.parametrize("name", ["som_weights", "som_seen", "learner", "iterations"])
    def test_something_is_missing(self, name):
        weights = self.learned().weights()
        del weights[name]
        with pytest.raises(ConfigError, match="lack"):
            make(Scene()).load(weights)

    @pytest.mark.parametrize(
        ("name", "array"),
        [
            ("som_weights", np.zeros((81, 1024), np.float32)),  # of a robot that saw images
            ("som_weights", np.zeros((64, 2), np.float32)),
            ("som_weights", np.array("words")),
            ("som_weights", np.array(1.0)),
            ("learner", np.zeros((81, 2))),
            ("learner", np.full((81, 21, 11), np.nan)),
            ("iterations", np.array([1, 2])),
            ("som_seen", np.array("many")),
        ],
    )
    def test_something_does_not_fit(self, name, array):
        weights = self.learned().weights() | {name: array}
        with pytest.raises(ConfigError, match="do not fit"):
            make(Scene()).load(weights)

    def test_a_mean_face(self):
        scene, config = Scene(), RobotConfig(mean_face=MeanFaceConfig(subtracted=True))
        scene.pattern_size = 1024
        robot = GazeFollower(config, scene, 2, np.random.SeedSequence(0))
        weights = robot.weights()
        robot.load(weights)
        for wrong in (np.zeros(1025), np.zeros((2, 2)), np.array("words")):
            with pytest.raises(ConfigError, match="mean face"):
                robot.load(weights | {"mean_face": wrong})
        spread = weights.pop("mean_face_spread")
        with pytest.raises(ConfigError, match="lack 'mean_face_spread'"):
            robot.load(weights)
        weights["mean_face_spread"] = spread
        without = GazeFollower(RobotConfig(), scene, 2, np.random.SeedSequence(0))
        with pytest.raises(ConfigError, match="hold deviations from a mean face"):
            without.load(weights)
        with pytest.raises(ConfigError, match="hold faces as they are"):
            robot.load(without.weights())

    def test_another_code(self):
        other = make(Scene(), learner={"code": "linear"})
        with pytest.raises(ConfigError, match="must have shape"):
            other.load(self.learned().weights())


def test_options_are_frozen():
    config = RobotConfig()
    assert replace(config, gaze=GazeConfig(gate="open")) != config
    assert hash(config) == hash(RobotConfig())


CROSS = {"code": "cross_situational", "pairs": "in_view", "base": "in_view"}


class TestObjects:
    """The learner commands objects in view rather than bare directions."""

    def knows(self, robot: GazeFollower, face: np.ndarray, location: int, other: int) -> None:
        """Teach the learner that this face goes with one location, and faces unlike it with another."""
        far = np.array([-25.0, 25.0])
        for seen, there in ((face, location), (far, other)):
            activations = robot.som.activations(seen)
            for _ in range(20):
                robot.learner.learn(activations, Locations.only(np.subtract(LOCATIONS[there], LOCATIONS[FACE])))

    def make(self, scene: Scene, *wanted: int, **gaze) -> GazeFollower:
        return make(scene, *wanted, gaze={"gate": "open", "commands": "object", **gaze}, learner=CROSS)

    def test_the_object_that_goes_with_the_face_is_looked_at(self):
        scene = Scene()
        robot = self.make(scene, FACE, RED)
        advance(robot, scene, 1)
        self.knows(robot, scene.face, BLUE, RED)
        shift = advance(robot, scene, 1)[0]
        assert (shift.by_learner, shift.chosen, shift.aim, shift.reached) == (True, RED, BLUE, BLUE)
        np.testing.assert_allclose(scene.head, LOCATIONS[BLUE], atol=1e-6)

    def test_visual_feedback_follows_it(self):
        scene = Scene()
        robot = self.make(scene, FACE, RED)
        advance(robot, scene, 1)
        self.knows(robot, scene.face, BLUE, RED)

        def carry():
            if robot.shift is not None:
                scene.locations[BLUE] = (-3.0, -5.0)

        assert advance(robot, scene, 1, carry)[0].reached == BLUE
        np.testing.assert_allclose(scene.head, (-3, -5), atol=1e-6)

    def test_without_evidence_the_eyes_decide(self):
        """Neither object goes better with the face: nothing was learned yet."""
        scene = Scene()
        robot = self.make(scene, FACE, BLUE)
        shift = advance(robot, scene, 2)[1]
        assert (shift.source, shift.by_learner, shift.reached) == (FACE, False, BLUE)

    def test_one_object_is_looked_at(self):
        scene = Scene()
        robot = self.make(scene, FACE, RED)
        advance(robot, scene, 1)
        scene.hidden = {BLUE}
        shift = advance(robot, scene, 1)[0]
        assert (shift.by_learner, shift.reached) == (True, RED)

    @pytest.mark.parametrize("gaze", [{}, {"gate": "certainty"}])
    def test_no_object_in_view(self, gaze):
        """The robot leaves the face for what attention chose before it vanished, or stays; nothing is learned."""
        scene = Scene()
        robot = self.make(scene, FACE, RED, **gaze)
        advance(robot, scene, 1)
        learned = robot.learner.weights()
        scene.hidden = {RED, BLUE}
        for _ in range(60):
            scene.frame(robot)
        assert robot.attended == FACE and robot.shift is None
        np.testing.assert_array_equal(robot.learner.weights(), learned)

    def test_every_look_at_the_face_is_learned(self):
        """On leaving it and on coming to it, with all objects in view, whatever was reached."""
        scene = Scene()
        robot = self.make(scene, FACE, RED, gate="shut")
        advance(robot, scene, 1)
        assert robot.learner.weights()[-1, -1] == 1
        leaving, coming = advance(robot, scene, 2)
        assert leaving.learned and coming.learned
        assert robot.learner.weights()[-1, -1] == 3
        assert robot.iterations == 1

    def test_certainty(self):
        """The gate opens as far as one object goes better with the face than the others."""
        scene = Scene()
        robot = self.make(scene, FACE, RED, gate="certainty")
        assert robot.gate_probability == 0
        advance(robot, scene, 2)
        assert robot.gate_probability == pytest.approx(0.5, abs=0.01)
        self.knows(robot, scene.face, BLUE, RED)
        advance(robot, scene, 2)
        assert robot.gate_probability > 0.9

    def test_waiting_for_a_still_face(self):
        scene = Scene()
        robot = self.make(scene, FACE, RED, wait_for_still_face=True)
        advance(robot, scene, 1)
        scene.moves[FACE] = True
        for _ in range(60):
            scene.frame(robot)
        assert robot.shift is None and robot.attended == FACE
        scene.moves[FACE] = False
        scene.frame(robot)
        assert robot.shift is not None and robot.shift.chosen == RED
        scene.moves[FACE] = True
        robot.attention.draw = Wants(BLUE)
        assert advance(robot, scene, 1)[0].reached == RED
        assert advance(robot, scene, 1)[0].reached == BLUE  # no face was left, so none is waited for

    def test_what_it_waited_for_is_gone(self):
        scene = Scene()
        robot = self.make(scene, FACE, RED, wait_for_still_face=True)
        advance(robot, scene, 1)
        scene.moves[FACE] = True
        for _ in range(30):
            scene.frame(robot)
        scene.hidden = {RED}
        scene.moves[FACE] = False
        scene.frame(robot)
        assert robot.shift is None and robot.attended == FACE

    @pytest.mark.parametrize(("reads", "reached"), [(True, BLUE), (False, RED)])
    def test_the_face_is_read_again_on_the_way(self, reads, reached):
        scene = Scene()
        robot = self.make(scene, FACE, RED, read_again=reads)
        advance(robot, scene, 1)
        first, later = np.array([20.0, 10.0]), np.array([-25.0, 25.0])
        self.knows(robot, first, RED, BLUE)
        scene.face = first

        def turn_away():
            if robot.shift is not None:
                scene.face = later

        shift = advance(robot, scene, 1, turn_away)[0]
        assert shift.by_learner and shift.reached == reached

    def test_a_bare_direction_is_read_again(self):
        scene = Scene()
        robot = self.make(scene, FACE, RED, commands="direction", read_again=True)
        advance(robot, scene, 1)
        first, later = np.array([20.0, 10.0]), np.array([-25.0, 25.0])
        self.knows(robot, first, RED, BLUE)
        scene.face = first

        def turn_away():
            if robot.shift is not None:
                scene.face = later

        shift = advance(robot, scene, 1, turn_away)[0]
        assert shift.aim is None and shift.reached == BLUE


@pytest.mark.parametrize(
    ("gaze", "learner", "named"),
    [
        ({"gate": "certainty"}, CROSS, "commands object"),
        ({"gate": "certainty", "commands": "object"}, {}, "cross_situational"),
        ({"read_again": True, "feedback_frames": ()}, CROSS, "feedback_frames"),
    ],
)
def test_options_that_contradict_each_other(gaze, learner, named):
    with pytest.raises(ConfigError, match=named):
        RobotConfig(gaze=GazeConfig(**gaze), learner=LearnerConfig(**learner))
