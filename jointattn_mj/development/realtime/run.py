"""The agent of chapter 5 in real time: attention ends a fixation, the agent chooses the next gaze target.

A step is a fixation. The attention selector of chapter 6 (eq. 6.1 to 6.7) is updated frame by frame. When it draws
another candidate than the fixated one, the step ends: the agent observes what is at the centre of view, chooses a gaze
target and a gesture, and the head turns there. The caregiver goes on all the time.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

from jointattn_mj.contingency.online.reactive import ReactiveModule
from jointattn_mj.development.agent import Developer, DeveloperConfig
from jointattn_mj.development.contingency_log import ContingencyLog
from jointattn_mj.development.loop import streams
from jointattn_mj.development.realtime.partner import PACE, PartnerConfig, PartnerWorld
from jointattn_mj.development.rendered.body import Witnessed
from jointattn_mj.development.rendered.observer import ObservedRun
from jointattn_mj.development.rendered.senses import CentralView, Senses, SensesConfig, px_off_centre
from jointattn_mj.development.table.caregiver import NOWHERE
from jointattn_mj.development.table.world import TableConfig
from jointattn_mj.errors import ConfigError
from jointattn_mj.gaze_following.attention import AttentionConfig, AttentionSelector
from jointattn_mj.gaze_following.fixation import attend
from jointattn_mj.gaze_following.gate import HeadShift
from jointattn_mj.io.rows import RowStore
from jointattn_mj.options import Checked, Real, Whole
from jointattn_mj.perception.categories import GroupingConfig
from jointattn_mj.perception.motion import MotionConfig
from jointattn_mj.perception.percept import Perceiver, Percept
from jointattn_mj.perception.pixels import PixelConfig, PixelPerception
from jointattn_mj.perception.state import StateConfig, StatePerception
from jointattn_mj.scene.camera import direction_of, directions_to
from jointattn_mj.scene.caregiver import FRAME_S, Phase
from jointattn_mj.scene.looker import spot_positions
from jointattn_mj.scene.objects import OBJECTS
from jointattn_mj.scene.variation import Variation, drawn, variation_of
from jointattn_mj.scene.world import AlignedObservation, WorldConfig, build_physics

FRAMES_PER_MINUTE = round(60 / FRAME_S)
AT_TEN_A_SECOND = MotionConfig(frames_back=1, face_px=0.0675, object_px=0.375)
"""Thresholds of chapter 6 for ten images a second."""


@dataclass(frozen=True)
class RealtimeConfig(Checked):
    """Settings of a real-time run: world, caregiver's pace, attention, perception."""

    world: WorldConfig = field(default_factory=lambda: WorldConfig(behaviour=PACE))
    """Looks of the scene and movements of the caregiver. Its objects are replaced by as many as the table has."""
    variation: Variation = "people+lights"
    """What differs between seeds, by names of ``scene.variation``; by default the caregiver and the light."""
    partner: PartnerConfig = field(default_factory=PartnerConfig)
    """Pace of the caregiver."""
    attention: AttentionConfig = field(default_factory=lambda: AttentionConfig(selection_period=9))
    """When a fixation ends (section 6.3.2): a draw each 0.3 s, the length of a human fixation. The 0.6 s of chapter 6
    would give the agent half as many steps."""
    perception: Literal["pixels", "state"] = "pixels"
    """What the robot perceives. ``pixels``: rendered images. ``state``: the simulator's state, with the errors
    measured for images."""
    senses: SensesConfig = field(
        default_factory=lambda: SensesConfig(
            pixels=PixelConfig(motion=AT_TEN_A_SECOND), grouping=GroupingConfig(most=6)
        )
    )
    """From percepts to values of sensors. In three minutes a face comes to rest some sixty times; more than six
    categories of so few faces are chance. A table of more than four spots needs more minutes and more categories."""
    state: StateConfig = field(default_factory=StateConfig)
    """Errors of ``perception state``."""
    looks_every: Annotated[int, Whole("[1, 10000]")] = 3
    """Frames from one image to the next while the head is still; 3 are ten images a second."""
    shift_frames: Annotated[int, Whole("[1, 10000]")] = 6
    """Frames over which the head's reference moves in a gaze shift. Chapter 6 takes a second; an hour would then
    have too few steps."""
    longest_s: Annotated[float, Real("(0, 1e6]")] = 5.0
    """Longest fixation, in seconds."""
    familiarise_minutes: Annotated[float, Real("(0, 1e6]")] = 3.0
    """Minutes of looking at the caregiver's face before all else (section 6.4.1), with a greeting first and last."""

    RENAMED: ClassVar = {"truth": "state"}
    OLD_CHOICES: ClassVar = {"perception": {"truth": "state"}}


class RealtimeRun(ObservedRun):
    """An agent and a caregiver who does not wait.

    Attributes:
        world: Bodies, 30 frames a second.
        attention: Attention selector, which ends a step.
        senses: From percepts to values of sensors.
        heads: (spots + 1, 2) gaze commands: head angles for each spot and for the caregiver's face, deg.
        frame: Frames since the agent's first step.
        on_frame: Called after every frame; for films.
    """

    on_frame: Callable[[], object] | None = None

    def __init__(
        self,
        table: TableConfig,
        config: RealtimeConfig,
        agent: DeveloperConfig,
        seed: int,
        n_steps: int,
        reactive: Sequence[ReactiveModule] = (),
        sample_every: int = 100,
    ):
        """Learn the caregiver's face.

        Args:
            table: Rules of the table and of the caregiver.
            config: World, pace, attention and perception.
            agent: Settings of detector, modules and selector.
            seed: 0 or more.
            n_steps: Longest possible run, in fixations.
            reactive: Initial modules; a joint without any moves at random.
            sample_every: Steps from one note of every event's contingency to the next.

        Raises:
            ConfigError: A number is out of range, or the robot found no face.
        """
        if table.objects > len(OBJECTS) or table.kinds > 1:
            raise ConfigError(
                f"the rendered table has at most {len(OBJECTS)} objects, all of one kind; "
                f"got {table.objects}, {table.kinds} kinds"
            )
        of_look, of_agent, of_world, of_perception, of_attention, of_senses = streams(seed, 6)
        self.config, self.table, self.spots = config, table, table.spots
        scene = replace(config.world.scene, objects=OBJECTS[: table.objects])
        world, conditions = drawn(replace(config.world, scene=scene), variation_of(config.variation), of_look)
        self.world = PartnerWorld(world, build_physics(world, conditions), of_world, conditions, config.partner, table)
        self._observation = AlignedObservation(self.world)
        self._perceiver = self._new_perceiver(np.random.default_rng(of_perception))
        self.attention = AttentionSelector(config.attention, table.objects, np.random.default_rng(of_attention))
        self.heads = np.vstack([directions_to(spot_positions(table.spots, world.scene)), np.zeros(2)])
        self._held = np.zeros(2)
        self.frame, self._gazes_at = 0, NOWHERE
        patterns, greetings = self._familiarised()
        self.senses = Senses(config.senses, table, patterns, greetings, np.random.default_rng(of_senses))
        self.frame, self._ended = 0, RowStore("ends", np.int32, 1)
        developer = Developer(self.senses.variables, agent, of_agent, reactive)
        super().__init__(developer, table, n_steps, sample_every)

    def __setstate__(self, state: dict[str, Any]) -> None:
        """See ``DevelopmentRun``."""
        super().__setstate__(state)
        if self.world.closed:
            return
        if self.world.conditions.sensor.delay and not isinstance(self._observation, AlignedObservation):
            raise ValueError("its robot did not know how late its camera is")

    @property
    def ended(self) -> np.ndarray:
        """(steps_done,) frame in which each step ended."""
        return self._ended.column(0)

    @property
    def minutes(self) -> float:
        """Simulated minutes since the agent's first step."""
        return self.frame / FRAMES_PER_MINUTE

    @property
    def spent(self) -> float:
        """See ``DevelopmentRun``."""
        return self.minutes

    def run_until(self, minutes: float) -> None:
        """Go on until so many simulated minutes have passed, to the end of a step."""
        while self.steps_done < self.n_steps and self.minutes < minutes:
            self.advance(1)

    def check(self) -> None:
        """See ``DevelopmentRun``."""
        super().check()
        self.senses.check()
        self.world.check()

    def more(self) -> dict[str, Any]:
        """See ``ObservedRun``; and simulated times."""
        return {
            "caregiver": self.world.config.scene.caregiver,
            "minutes": self.minutes,
            "minutes_when_detected": [self.minutes_at(detection.step) for detection in self.detections],
            **super().more(),
        }

    def minutes_at(self, step: int) -> float:
        """Simulated minutes after which so many steps were done."""
        return float(self._ended.column(0, step - 1, step)[0]) / FRAMES_PER_MINUTE

    def close(self) -> None:
        """Free the world's model and images."""
        self.world.close()

    def sense(self, number: int) -> Witnessed:
        """See ``ObservedRun``: shift the gaze if it was commanded, and fixate until attention would shift it again."""
        location = int(self.agent.state.a[0]) if number else self.spots
        if location != self._gazes_at:
            self._shift(location)
        view = self._fixate()
        partner, at_face = self.world.caregiver, location == self.spots
        there = not at_face and partner.full(location)
        sensors = np.array([partner.looks_at if at_face else self.spots + 1, not there])
        results = np.array([at_face and partner.looks_at == self.spots, at_face, there])
        self.senses.read(view, sensors, results, self._s, self._r)
        self._ended.append(self.frame)
        return Witnessed(partner.looks_at, partner.option, there)

    def _shift(self, location: int) -> None:
        """Turn the head to a gaze target; the caregiver sees it turn, and where it comes to rest."""
        movement = HeadShift(self._held, self.heads[location], self.config.shift_frames)
        self.world.caregiver.watch(NOWHERE)
        while not movement.commanded or self._observation.head_moves:
            self._held = movement.next_reference()
            self._step()
        self._gazes_at = location
        self.world.caregiver.watch(location)

    def _fixate(self) -> CentralView:
        """Fixate until the attention selector chooses another candidate; returns what is at the centre of view then."""
        self.attention.settle()
        longest = round(self.config.longest_s / FRAME_S)
        for frame in range(longest):
            if frame % self.config.looks_every == 0:
                percept = self._perceiver.perceive(self._observation, frame == 0)
                attended = self._at_centre(percept)
            chosen = attend(self.attention, attended, percept)
            self._step()
            if chosen is not None:
                break
        return self._central_view(percept, attended)

    def _step(self) -> None:
        self.world.step(np.radians(self._held))
        self.frame += 1
        if self.on_frame is not None:
            self.on_frame()

    def _at_centre(self, percept: Percept) -> int | None:
        """Candidate nearest to the centre of view, if it is within the radius of what is gazed at."""
        off = px_off_centre(percept)
        nearest = int(off.argmin())
        return nearest if off[nearest] <= self.config.senses.centre_radius_px else None

    def _central_view(self, percept: Percept, attended: int | None) -> CentralView:
        face = attended == self.table.objects
        pattern = self._perceiver.face_pattern() if face else None
        is_object = attended is not None and not face
        return CentralView(face, is_object, percept.px[-1].copy(), percept.px[attended or 0].copy(), pattern)

    def _new_perceiver(self, rng: np.random.Generator) -> Perceiver:
        if self.config.perception == "state":
            return StatePerception(self.config.state, self.world, rng)
        colours = np.array([item.rgb for item in OBJECTS[: self.table.objects]])
        return PixelPerception(self.config.senses.pixels, colours)

    def _familiarised(self) -> tuple[np.ndarray, int]:
        """Look at the caregiver's face for some minutes, with a greeting before and after.

        A face counts once each time it comes to rest; counted at every image, each rest would become a category. The
        second greeting is needed because a face is cut out differently when more of its views are known.

        Returns:
            Patterns (n, d) of the face, those of greetings first, and the number of these.
        """
        greetings, others = list[np.ndarray](), list[np.ndarray]()
        partner, visible, moved, again = self.world.caregiver, 0, True, False
        partner.watch(self.spots)
        while partner.greeting or not again:
            percept = self._perceiver.perceive(self._observation, visible == 0)
            if percept.visible[-1]:
                visible += 1
                there = direction_of(percept.px[-1], np.degrees(self._observation.head_angles))
                self._held = self._held + (there - self._held) / visible
                moved = moved or bool(percept.moves[-1])
                if moved and not percept.moves[-1] and not self._observation.head_moves:
                    moved = False
                    group = greetings if partner.phase == Phase.GREET else others
                    group.append(self._perceiver.face_pattern().copy())
            for _ in range(self.config.looks_every):
                self._step()
            if not again and self.minutes >= self.config.familiarise_minutes:
                again = True
                partner.greet()
        if not greetings:
            raise ConfigError("the robot found no frontal face during the greeting; change variation, or the scene")
        self.heads[-1], self._gazes_at = self._held, self.spots
        return np.array(greetings + others), len(greetings)

    def _written_down(self) -> tuple[RowStore | ContingencyLog, ...]:
        return *super()._written_down(), self._ended
