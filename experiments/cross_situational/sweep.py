"""Sessions of chapter 6 with the cross-situational learner: with one part left out, and in harder conditions."""

from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.gaze_following.agent import GazeFollower, GazeShift, RobotConfig
from jointattn_mj.gaze_following.learners import Locations
from jointattn_mj.gaze_following.presets import PRESETS
from jointattn_mj.gaze_following.session import FRAMES_PER_MINUTE, SessionRun
from jointattn_mj.gaze_following.varied_session import VariedSessionConfig, VariedSessionRun
from jointattn_mj.options import Checked, Real, Share, Whole
from jointattn_mj.perception.mean_face import MeanFaceConfig
from jointattn_mj.perception.percept import Observation, Perceiver
from jointattn_mj.perception.pixels import PixelPerception
from jointattn_mj.perception.som import SOMConfig
from jointattn_mj.scene.camera import direction_of
from jointattn_mj.scene.layout import LayoutConfig
from jointattn_mj.scene.objects import OBJECTS
from jointattn_mj.scene.variation import drawn
from jointattn_mj.scene.world import World
from jointattn_mj.sweeps.claim import Setting

from .caregivers import PLANE_X, UprightWorld, world_with
from .told import PARTS, Part, PartlyTold

FULL = PRESETS["cross_situational"]
LOOK_EVERY = 90
"""Frames between two looks of a robot that only watches: as many looks as one that acts has, some twenty a minute."""
TEST_MINUTES = 6.0
"""At the end of a session in which the robot watched."""


@dataclass(frozen=True)
class Condition(Checked):
    """A session, what its caregiver does, and whether the robot acts while it learns."""

    config: VariedSessionConfig
    looks_away: Share = 0.0
    """Probability, in each phase after turning to an object, that the caregiver looks at an empty position instead."""
    looks_at_others: bool = False
    """Whether the caregiver's gaze rests on an object that is not handled."""
    handled: Annotated[int, Whole("[1, 10]")] | None = None
    """Number of objects that the caregiver transfers; the rest are distractors. None for all."""
    learning: Literal["acting", "watching"] = "acting"
    """Watching: no gaze shift is made before the test, and nothing is learned in it."""


@dataclass(frozen=True)
class Upright(Condition):
    """A session whose objects hang in a plane, side by side and above each other (see ``UprightScript``)."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.looks_away or self.looks_at_others or self.handled is not None:
            raise ConfigError("where objects hang in a plane the caregiver looks at what is handled, and handles all")


@dataclass(frozen=True)
class PartlyVisible(Condition):
    """A session from images in which the robot is told parts of the percept by the state, without error."""

    told: Part = "all"
    """What the state tells (see ``told``)."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.config.perception != "pixels":
            raise ConfigError(f"told {self.told} needs perception pixels; got {self.config.perception}")


@dataclass(frozen=True)
class Strangers(Checked):
    """A robot that learns with some caregivers and then meets others."""

    config: VariedSessionConfig
    teachers: tuple[str, ...]
    """Caregivers of whom it learns the faces and the map, for equal parts of the config's minutes."""
    strangers: tuple[str, ...]
    """Caregivers whom it meets afterwards, each on its own: the faces it knows stay those of the teachers."""
    minutes: Annotated[float, Real("(0, 1e3]")] = 6.0
    """With each of them; learning goes on, and the learner commands all shifts."""


def robot(
    start: RobotConfig,
    cues: bool,
    gaze: dict[str, Any] | None = None,
    learner: dict[str, Any] | None = None,
    faces: dict[str, Any] | None = None,
) -> RobotConfig:
    """A robot with some settings changed.

    Args:
        start: Its settings before.
        cues: Whether motion cues attract attention.
        gaze: Changed fields of its ``gaze``.
        learner: Changed fields of its ``learner``.
        faces: Changed fields of its own that say how it codes faces.
    """
    return replace(
        start,
        attention=replace(start.attention, motion_cues=cues),
        gaze=replace(start.gaze, **(gaze or {})),
        learner=replace(start.learner, **(learner or {})),
        **(faces or {}),
    )


def condition(
    perception: str = "state",
    cues: bool = False,
    preset: str = "cross_situational",
    gaze: dict[str, Any] | None = None,
    learner: dict[str, Any] | None = None,
    faces: dict[str, Any] | None = None,
    minutes: float = 26.0,
    objects: int = 4,
    variation: str = "none",
    knows_delay: bool = True,
    kind: type[Condition] = Condition,
    **more: Any,
) -> Condition:
    """A session with some settings changed.

    Args:
        perception: ``pixels`` or ``state``.
        cues: Whether motion cues attract attention.
        preset: Of the robot.
        gaze: Changed fields of its ``gaze``.
        learner: Changed fields of its ``learner``.
        faces: Changed fields of its own that say how it codes faces.
        minutes: Length.
        objects: How many there are on the table.
        variation: What of the world varies with the seed.
        knows_delay: Whether the robot knows how late its camera is.
        kind: Class of the condition.
        more: Further fields of ``Condition``.
    """
    config = VariedSessionConfig(
        minutes=minutes,
        perception=perception,
        variation=variation,
        knows_delay=knows_delay,
        robot=robot(PRESETS[preset], cues, gaze, learner, faces),
    )
    scene = replace(config.world.scene, objects=OBJECTS[:objects])
    return kind(replace(config, world=replace(config.world, scene=scene)), **more)


def upright(**options: Any) -> Upright:
    """A session with three objects in an upright square: 14 degrees wide and high for the robot, 16 and 15 for the
    caregiver.

    Args:
        options: Of ``condition``.
    """
    made = condition(objects=3, learner={"units": (21, 13)}, kind=Upright, **options)  # 2.5 degrees on either axis
    layout = LayoutConfig(x_range=(0.74, 0.94), y_range=(-0.1, 0.1), spacing=0.09, cells=(4, 4))
    world = made.config.world
    behaviour = replace(world.behaviour, holding_location=(PLANE_X, 0.0, 0.84))
    assert isinstance(made, Upright)
    return replace(made, config=replace(made.config, world=replace(world, layout=layout, behaviour=behaviour)))


def meeting(teachers: int, subtracted: bool) -> Strangers:
    """A robot that learns with some people and then meets the others; faces as they are, or less their mean."""
    config = condition("pixels").config
    mean_face = MeanFaceConfig(subtracted=subtracted)
    alike = replace(config, robot=replace(config.robot, mean_face=mean_face))
    return Strangers(alike, PEOPLE[:teachers], PEOPLE[teachers:])


COMPLETE = "in_view+base+competition+wait+again"


def ablation() -> dict[str, Setting]:
    """All combinations of pairs, base rate, competition, waiting and reading again, without cues, from the state."""
    settings = {}
    for pairs, base, competition, wait, again in product(("reached", "in_view"), *[(False, True)] * 4):
        parts = {"base": base, "competition": competition, "wait": wait, "again": again}
        name = "+".join([pairs, *(part for part, on in parts.items() if on)])
        learner = {"pairs": pairs, "base": "in_view" if base else "none", "competition": float(competition)}
        gaze = {"wait_for_still_face": wait, "read_again": again}
        settings[f"ablation/{name}"] = Setting(condition(gaze=gaze, learner=learner), 20)
    del settings[f"ablation/{COMPLETE}"]  # it is state/no_cues
    return settings


FACES_OF_THE_THESIS: dict[str, Any] = {"som": SOMConfig(), "mean_face": MeanFaceConfig(), "face_at": "found"}
PEOPLE = ("robin", "noa", "kai", "amara", "elin", "tove")
SETTINGS = {
    "state/no_cues": Setting(condition(), 20),
    "state/cues": Setting(condition(cues=True), 20),
    "state/no_cues_thesis": Setting(condition(preset="thesis"), 20),
    "state/cues_thesis": Setting(condition(cues=True, preset="thesis"), 20),
    "pixels/no_cues": Setting(condition("pixels"), 20),
    "pixels/cues": Setting(condition("pixels", cues=True), 20),
    **ablation(),
    "changed/gate_by_certainty": Setting(condition(gaze={"gate": "certainty"}), 20),
    "changed/gate_of_the_thesis": Setting(condition(gaze={"gate_midpoint": 150.0, "gate_width": 22.5}), 20),
    "changed/bare_direction": Setting(condition(gaze={"commands": "direction"}), 20),
    "changed/nothing_forgotten": Setting(condition(learner={"forgetting": 0.0}), 20),
    "changed/41x31_units": Setting(condition(learner={"units": (41, 31)}), 20),
    "changed/half_a_second_a_shift": Setting(condition(gaze={"shift_frames": 15, "feedback_frames": (10,)}), 20),
    "changed/map_of_9x9_patterns": Setting(condition(faces={"som": SOMConfig()}), 20),
    **{f"objects/{count}": Setting(condition(objects=count), 20) for count in (2, 3, 5, 6, 8)},
    "objects/8_of_which_4_are_handled": Setting(condition(objects=8, handled=4), 20),
    **{f"caregiver/looks_away_{share:.0%}": Setting(condition(looks_away=share), 20) for share in (0.2, 0.4, 0.6)},
    "caregiver/looks_at_others": Setting(condition(looks_at_others=True), 20),
    "watching": Setting(condition(gaze={"gate": "open"}, minutes=26 + TEST_MINUTES, learning="watching"), 20),
    "watching_thesis": Setting(
        condition(preset="thesis", gaze={"gate": "open"}, minutes=26 + TEST_MINUTES, learning="watching"), 20
    ),
    "hour": Setting(condition(minutes=60), 20),
    "variation": Setting(condition("pixels", variation="all"), 10),
    "variation_delay_not_known": Setting(condition("pixels", variation="all", knows_delay=False), 10),
    "strangers/one_teacher": Setting(meeting(1, subtracted=True), 10),
    "strangers/one_teacher_faces_as_they_are": Setting(meeting(1, subtracted=False), 10),
    "strangers/three_teachers": Setting(meeting(3, subtracted=True), 10),
    "faces/where_found": Setting(condition("pixels", faces={"face_at": "found"}), 20),
    "faces/of_the_thesis": Setting(condition("pixels", faces=FACES_OF_THE_THESIS), 20),
    **{
        f"told/{part}": Setting(condition("pixels", faces=FACES_OF_THE_THESIS, kind=PartlyVisible, told=part), 10)
        for part in PARTS
    },
    "upright/state_no_cues": Setting(upright(), 20),
    "upright/state_cues_thesis": Setting(upright(cues=True, preset="thesis"), 20),
    "upright/pixels_no_cues": Setting(upright(perception="pixels"), 10),
    "upright/pixels_cues_thesis": Setting(upright(perception="pixels", cues=True, preset="thesis"), 10),
}  # fmt: skip
"""Under string ids: what is asked, a slash, and what is changed in the robot with all parts, from the state and without
motion cues unless it says otherwise."""
FILM = Path(__file__).with_name("side_by_side.mp4")
"""Two robots side by side (see ``film``)."""
FIRST_SEED = 60_000
"""Held-out seeds; the design and its numbers were chosen on others."""
COLUMNS = ("landing_s", "success", "success_at_launch", "success_at_landing", "phase_at_launch", "on_nothing")
"""Kept of every shift from the face to an object."""
ERRORS = ("pan_error_deg", "tilt_error_deg")
"""Kept beside them where objects hang in a plane."""


class ConditionRun(VariedSessionRun):
    """A session with a caregiver, and a robot, of its condition."""

    def __init__(self, condition: Condition, seed: int):
        self._condition = condition
        super().__init__(replace(condition.config, seed=seed))

    def new_world(self, seed: np.random.SeedSequence) -> World:
        """See ``SessionRun``."""
        asked = self._condition
        kind = world_with(asked.looks_away, asked.looks_at_others, asked.handled)
        if isinstance(asked, Upright):
            kind = UprightWorld
        world, conditions = drawn(self.config.world, self.config.ranges, seed)
        return kind.build(world, seed, conditions)

    def new_perceiver(self, rng: np.random.Generator) -> Perceiver:
        """See ``SessionRun``."""
        perceiver = super().new_perceiver(rng)
        if isinstance(self._condition, PartlyVisible) and isinstance(perceiver, PixelPerception):
            return PartlyTold(perceiver, self.world, self._condition.told)
        return perceiver

    def new_robot(self, perceiver: Perceiver, seed: np.random.SeedSequence) -> GazeFollower:
        """See ``SessionRun``."""
        kind = OnlyWatching if self._condition.learning == "watching" else GazeFollower
        made = kind(self.config.robot, perceiver, len(self.config.world.scene.objects), seed)
        if isinstance(made, OnlyWatching):
            made.frames_left = round((self.config.minutes - TEST_MINUTES) * FRAMES_PER_MINUTE)
        return made


class OnlyWatching(GazeFollower):
    """Looks at the face and learns from looks alone, without a gaze shift; then shifts its gaze, and learns nothing.

    Attributes:
        frames_left: Frames for which it still watches.
    """

    frames_left = 0

    def act(self, observation: Observation) -> np.ndarray:
        """See ``GazeFollower``."""
        if not self.frames_left:
            return super().act(observation)
        self.frames_left -= 1
        self.landed, self.attended = None, self.face
        head = np.degrees(observation.head_angles)
        self.percept = percept = self.perceiver.perceive(observation, landed=False)
        if percept.visible[self.face]:
            self._hold(direction_of(percept.px[self.face], head))
            if self.frames_left % LOOK_EVERY == 0:
                self.learner.learn(self.face_input(), Locations(self._in_view(percept, head)))
        return self._command

    def _pair(self, shift: GazeShift, face: np.ndarray, locations: Locations) -> None:
        """Nothing is learned from own shifts."""


def trial(asked: Condition | Strangers, seed: int) -> dict[str, Any]:
    """Trial: what ``COLUMNS`` names of each shift launched while the caregiver looked at an object, and a summary."""
    if isinstance(asked, Strangers):
        return _meet_strangers(asked, seed)
    session = ConditionRun(asked, seed)
    try:
        session.begin()
        session.finish()
        summary = session.summary(0.0)
        kept = ("gaze_shifts", "successes", "landings_on_nothing", "learning_iterations")
        return {
            **{name: getattr(summary, name) for name in kept},
            "map_error_deg": summary.map_error_deg.median,
            "shifts": _shifts(session, (*COLUMNS, *ERRORS) if isinstance(asked, Upright) else COLUMNS),
        }
    finally:
        session.close()


def _shifts(session: SessionRun, columns: tuple[str, ...] = COLUMNS) -> dict[str, list[Any]]:
    rows = [row for row in session.shifts if row.face_to_object and row.target_at_launch is not None]
    return {name: [getattr(row, name) for row in rows] for name in columns}


def _meet_strangers(asked: Strangers, seed: int) -> dict[str, Any]:
    """Trial: the shifts with each stranger, under the stranger's name."""
    config, teachers = asked.config, asked.teachers
    seeds = iter(np.random.SeedSequence(seed).generate_state(2 * len(teachers) + len(asked.strangers)).tolist())
    faces = replace(config.robot.familiarise, minutes=config.robot.familiarise.minutes / len(teachers))
    familiar = replace(config, robot=replace(config.robot, familiarise=faces))
    weights: dict[str, np.ndarray] | None = None
    for name in teachers:
        weights, _ = _visit(_with(familiar, name, next(seeds), 0.0), weights, learns_faces=True)
    for name in teachers:
        weights, _ = _visit(_with(config, name, next(seeds), config.minutes / len(teachers)), weights)
    opened = replace(config, robot=replace(config.robot, gaze=replace(config.robot.gaze, gate="open")))
    return {name: _visit(_with(opened, name, next(seeds), asked.minutes), weights)[1] for name in asked.strangers}


def _with(config: VariedSessionConfig, caregiver: str, seed: int, minutes: float) -> VariedSessionConfig:
    """A session with another caregiver, seed and length; 0 minutes for what comes before a session alone."""
    scene = replace(config.world.scene, caregiver=caregiver)  # type: ignore[arg-type]
    world = replace(config.world, scene=scene)
    return replace(config, seed=seed, world=world, minutes=minutes or 1 / FRAMES_PER_MINUTE)


def _visit(
    config: VariedSessionConfig, weights: dict[str, np.ndarray] | None, learns_faces: bool = False
) -> tuple[dict[str, np.ndarray], dict[str, list[Any]]]:
    """What a robot knows after a session that it began with ``weights``, and its shifts.

    Args:
        config: Of the session.
        weights: What it knew before; None for nothing.
        learns_faces: Whether it looks at the caregiver's face before the session, and learns its patterns.
    """
    session = VariedSessionRun(config)
    try:
        if weights is not None:
            session.robot.load(weights)
        if learns_faces:
            session.begin()
        session.finish()
        return session.weights(), _shifts(session)
    finally:
        session.close()
