"""The mind of chapter 5 in real time: attention decides when it has looked long enough, the mind where it looks next.

A step is a fixation. The attention selector of chapter 6 (eq. 6.1 to 6.7) lives through it frame by frame; when it
draws something else than what is fixated, the step is over: what the robot sees at that moment is observed, the mind
chooses where to look and what gesture to make, and the head turns there. The caregiver goes on all the time.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

from jointattn_mj.contingency.online.reactive import ReactiveModule
from jointattn_mj.development.agent import Developer, DeveloperConfig
from jointattn_mj.development.contingency_log import ContingencyLog
from jointattn_mj.development.realtime.partner import PACE, PartnerConfig, PartnerWorld
from jointattn_mj.development.rendered.body import Witnessed
from jointattn_mj.development.rendered.observer import ObservedRun
from jointattn_mj.development.rendered.senses import CentralView, Senses, SensesConfig
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
from jointattn_mj.scene.camera import CENTRE_X, CENTRE_Y, FOCAL_PX, direction_of, directions_to
from jointattn_mj.scene.caregiver import FRAME_S, Phase
from jointattn_mj.scene.looker import locations
from jointattn_mj.scene.model import OBJECTS
from jointattn_mj.scene.variation import Variation, drawn, variation_of
from jointattn_mj.scene.world import Observation, WorldConfig, build_physics

FRAMES_PER_MINUTE = round(60 / FRAME_S)
AT_TEN_A_SECOND = MotionConfig(frames_back=1, face_px=0.0675, object_px=0.375)
"""Ten images a second: the speeds of chapter 6 over the tenth of a second between two of them."""


@dataclass(frozen=True)
class RealtimeConfig(Checked):
    """What lies between the caregiver's life and the mind's steps."""

    world: WorldConfig = field(default_factory=lambda: WorldConfig(behaviour=PACE))
    """What things look like and how she moves; its objects are replaced by as many as the table has."""
    variation: Variation = "people+lights"
    """How each seed's world differs, by names of ``scene.variation``: she is one of six people, in her own light."""
    partner: PartnerConfig = field(default_factory=PartnerConfig)
    """Her pace."""
    attention: AttentionConfig = field(default_factory=lambda: AttentionConfig(selection_period=9))
    """When a fixation is over (section 6.3.2); a draw each 0.3 s, the length of a human fixation, for steps are what
    the mind needs. Chapter 6's 0.6 s gave its number of gaze shifts."""
    perception: Literal["pixels", "state"] = "pixels"
    """Rendered images, or the simulator's state with the errors that the pixel path was measured to make."""
    senses: SensesConfig = field(
        default_factory=lambda: SensesConfig(
            pixels=PixelConfig(motion=AT_TEN_A_SECOND), grouping=GroupingConfig(most=6)
        )
    )
    """From percepts to sensations. In three minutes a face comes to rest some sixty times; in so few faces more than
    six categories are chance, and a table of more than four places needs more minutes and more categories."""
    state: StateConfig = field(default_factory=StateConfig)
    """What stands for images with ``perception state``."""
    looks_every: Annotated[int, Whole("[1, 10000]")] = 3
    """Frames from one image to the next while the head is still: ten images a second."""
    shift_frames: Annotated[int, Whole("[1, 10000]")] = 6
    """Frames over which the head's reference moves in a gaze shift. Chapter 6 takes a second; a mind that has an hour
    needs steps."""
    longest_s: Annotated[float, Real("(0, 1e6]")] = 5.0
    """A fixation that nothing ends lasts so long."""
    familiarise_minutes: Annotated[float, Real("(0, 1e6]")] = 3.0
    """Minutes of looking at the caregiver's face before all else (section 6.4.1); she greets the robot first."""

    RENAMED: ClassVar = {"truth": "state"}
    OLD_CHOICES: ClassVar = {"perception": {"truth": "state"}}


class RealtimeRun(ObservedRun):
    """A mind, a body and a caregiver who does not wait.

    Attributes:
        world: Bodies, 30 frames a second.
        attention: Says when a step is over.
        senses: What is made of percepts.
        heads: (spots + 1, 2) the robot's gaze commands: head angles for each place and for the caregiver's face, deg.
        frame: Frames since the mind began.
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
        """The robot knows the caregiver's face when this returns. ``n_steps``: the most steps there can be."""
        if seed < 0:
            raise ConfigError(f"seed must be 0 or more; got {seed}")
        if table.objects > len(OBJECTS) or table.kinds > 1:
            raise ConfigError(
                f"the scene knows {len(OBJECTS)} objects, all of one kind to the mind; "
                f"got {table.objects}, {table.kinds} kinds"
            )
        of_look, of_agent, of_world, of_perception, of_attention, of_senses = np.random.SeedSequence(seed).spawn(6)
        self.config, self.table, self.spots = config, table, table.spots
        scene = replace(config.world.scene, objects=OBJECTS[: table.objects])
        world, conditions = drawn(replace(config.world, scene=scene), variation_of(config.variation), of_look)
        self.world = PartnerWorld(world, build_physics(world, conditions), of_world, conditions, config.partner, table)
        self._observation = Observation(self.world)
        self._perceiver = self._new_perceiver(np.random.default_rng(of_perception))
        self.attention = AttentionSelector(config.attention, table.objects, np.random.default_rng(of_attention))
        self.heads = np.vstack([directions_to(locations(table.spots, world.scene)), np.zeros(2)])
        self._held = np.zeros(2)
        self.frame, self._gazes_at = 0, NOWHERE
        patterns, greetings = self._familiarised()
        self.senses = Senses(config.senses, table, patterns, greetings, np.random.default_rng(of_senses))
        self.frame, self._ended = 0, RowStore("steps", np.int32, 1)
        developer = Developer(self.senses.variables, agent, of_agent, reactive)
        super().__init__(developer, table, n_steps, sample_every)

    @property
    def ended(self) -> np.ndarray:
        """(lived,) frame in which each step was over."""
        return self._ended.column(0)

    @property
    def minutes(self) -> float:
        """Simulated minutes since the mind began."""
        return self.frame / FRAMES_PER_MINUTE

    @property
    def spent(self) -> float:
        """See ``DevelopmentRun``."""
        return self.minutes

    def run_until(self, minutes: float) -> None:
        """Live until so many simulated minutes have passed, to the end of a step."""
        while self.steps_done < self.n_steps and self.minutes < minutes:
            self.advance(1)

    def check(self) -> None:
        """See ``DevelopmentRun``."""
        super().check()
        self.senses.check()
        self.world.check()

    def more(self) -> dict[str, Any]:
        """See ``ObservedRun``; and how much time it took."""
        return {
            "caregiver": self.world.config.scene.caregiver,
            "minutes": self.minutes,
            "minutes_when_found": [self.minutes_at(one.step) for one in self.found],
            **super().more(),
        }

    def minutes_at(self, step: int) -> float:
        """Simulated minutes that had passed when so many steps had been lived."""
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
        """Turn the head; she sees it turn, and where it comes to rest."""
        movement = HeadShift(self._held, self.heads[location], self.config.shift_frames)
        self.world.caregiver.watch(NOWHERE)
        while not movement.commanded or self.world.head_moves():
            self._held = movement.next_reference()
            self._step()
        self._gazes_at = location
        self.world.caregiver.watch(location)

    def _fixate(self) -> CentralView:
        """Live until the attention selector would look at something else; what is then at the centre of view."""
        self.attention.settle()
        longest = round(self.config.longest_s / FRAME_S)
        for frame in range(longest):
            if frame % self.config.looks_every == 0:
                percept = self._perceiver.look(self._observation, frame == 0)
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
        """The candidate that is nearest to the centre of view, if that is near enough to be gazed at."""
        off = np.hypot(percept.px[:, 0] - CENTRE_X, percept.px[:, 1] - CENTRE_Y)
        off[~percept.visible] = np.inf
        nearest = int(off.argmin())
        return nearest if off[nearest] <= np.radians(self.config.senses.centre_radius_deg) * FOCAL_PX else None

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
        """Minutes of looking at her face, with a greeting before and after; patterns (n, d) of it whenever it has come
        to rest, those that greeted the robot first, and how many these are.

        A face that has not moved since is not another face: counted at every look, each rest of hers would be a
        category. She greets again because a face is cut out a little otherwise when more of its views are known.
        """
        greetings, others = list[np.ndarray](), list[np.ndarray]()
        partner, visible, moved, again = self.world.caregiver, 0, True, False
        partner.watch(self.spots)
        while partner.greeting or not again:
            percept = self._perceiver.look(self._observation, visible == 0)
            if percept.visible[-1]:
                visible += 1
                there = direction_of(percept.px[-1], np.degrees(self.world.head_angles()))
                self._held = self._held + (there - self._held) / visible
                moved = moved or bool(percept.moves[-1])
                if moved and not percept.moves[-1] and not self.world.head_moves():
                    moved = False
                    group = greetings if partner.phase == Phase.GREET else others
                    group.append(self._perceiver.face_pattern().copy())
            for _ in range(self.config.looks_every):
                self._step()
            if not again and self.minutes >= self.config.familiarise_minutes:
                again = True
                partner.greet()
        if not greetings:
            raise ConfigError("the robot found no face that greeted it; change variation, or the scene")
        self.heads[-1], self._gazes_at = self._held, self.spots
        return np.array(greetings + others), len(greetings)

    def _written_down(self) -> tuple[RowStore | ContingencyLog, ...]:
        return *super()._written_down(), self._ended
