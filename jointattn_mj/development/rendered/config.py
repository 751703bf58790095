"""``jointattn develop rendered``: options of a run at a table that the robot sees, one image a step."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from jointattn_mj.contingency.online.resolution import ResolutionConfig
from jointattn_mj.development.config import DevelopmentConfig, DevelopmentOptions, Every
from jointattn_mj.development.loop import DevelopmentRun
from jointattn_mj.development.meaning import meanings
from jointattn_mj.development.rendered.continuous import SCATTERED, ContinuousConfig, ContinuousRun
from jointattn_mj.development.rendered.film import RunFilm
from jointattn_mj.development.rendered.growing import Babbling, FreeGazeBody, GrowingConfig, GrowingRun, RecallingBody
from jointattn_mj.development.rendered.growth_film import GrowthFilm
from jointattn_mj.development.rendered.run import RenderedConfig, RenderedRun
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.errors import ConfigError
from jointattn_mj.options import Checked, Choice, Real, Whole

GROWING = GrowingConfig()
LEAST_TURNED = 60
"""Preset local: ``least_turned``. A robot that had seen 15 turned faces in place of 96 or more took all for alike."""


@dataclass(frozen=True)
class BabblingConfig(Checked):
    """Options of babbling: the gaze moves at random, and values of faces and gaze split where contingency rises."""

    steps: Annotated[int, Whole("[1, 1e10]")] = 20_000
    """Steps of babbling before the agent begins."""
    images: bool = True
    """Render an image every step. Without it faces come from an album of images and objects from geometry: 20,000 steps
    then take seconds, and nothing can be filmed."""
    face_share: Annotated[float, Real("(0, 1)")] = GROWING.face_share
    """Share of gaze shifts to the caregiver's face; the others go in a random direction."""
    margin: Annotated[float, Real("[0, 0.5)")] = GROWING.margin
    """Share of the directions of seen objects that is left out at each end of an axis, since some are wrong."""
    resolution: ResolutionConfig = field(default_factory=ResolutionConfig)
    """When values split."""


@dataclass(frozen=True)
class RenderedDevelopmentConfig(DevelopmentConfig):
    """Options of a run at the same table, which the robot sees in rendered images; bodies are imprecise."""

    world: Literal["rendered"] = "rendered"
    preset: Annotated[str, Choice(PRESETS)] = "fast"
    """Reading of the text that gives --table.* and --agent.* their defaults, as at the table. A step takes an image's
    time, so the preset that needs the fewest is the default."""
    steps: Annotated[int, Whole("[1, 1e10]")] = 20_000
    """Length of the run in steps; 20,000 take half a minute without a GPU."""
    maps: Literal["discrete", "continuous"] = "discrete"
    """Where the map of gaze following leads. discrete: to one of the table's locations. continuous: to any direction,
    learned from faces and objects seen since the module was made (section 7.1); objects then lie anywhere in the row,
    and --continuous.* applies."""
    resolution: Literal["given", "growing"] = "given"
    """Values of faces and gaze. given: categories of faces, and the table's locations. growing: both split where
    contingency rises while the robot babbles (section 7.1), and --babbling.* applies."""
    rendered: RenderedConfig = field(default_factory=RenderedConfig)
    continuous: ContinuousConfig = field(default_factory=ContinuousConfig)
    babbling: BabblingConfig = field(default_factory=BabblingConfig)

    GONE: ClassVar[Sequence[str]] = ("mode",)
    CHOOSES: ClassVar[tuple[tuple[str, str], ...]] = (("maps", "continuous"), ("resolution", "growing"))
    steps_at_a_time: ClassVar[int] = 500
    checkpoint_every: ClassVar[int] = 10_000

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.maps == "continuous" and self.resolution == "growing":
            raise ConfigError("maps continuous needs the table's locations; choose resolution given, or maps discrete")
        if self.resolution == "growing" and self.rendered.senses.frontal_likeness:
            raise ConfigError(
                "resolution growing knows frontal faces by units of the map: it needs senses.frontal_likeness 0; "
                f"got {self.rendered.senses.frontal_likeness}"
            )
        if self.resolution == "growing" and self.rendered.draws == "centre":
            raise ConfigError("resolution growing learns from what lies beside the centre: it needs rendered.draws all")

    @classmethod
    def defaults(cls, given: Mapping[str, Any]) -> Self:
        """See ``DevelopmentConfig``; those of --rendered.* also follow from --maps and --resolution."""
        start = super().defaults(given)
        if start.preset == "local":
            start = replace(start, rendered=replace(start.rendered, least_turned=LEAST_TURNED))
        if given.get("resolution") == "growing":
            senses, calibration, exploration = GROWING.senses, GROWING.calibration, GROWING.exploration
            rendered = replace(start.rendered, senses=senses, calibration=calibration, exploration=exploration)
            return replace(start, rendered=rendered)
        if given.get("maps") == "continuous":
            return replace(start, rendered=replace(SCATTERED, least_turned=start.rendered.least_turned))
        return start

    @property
    def films(self) -> bool:
        """See ``DevelopmentConfig``; without images bodies do not move."""
        return self.resolution == "given" or self.babbling.images

    @property
    def kind(self) -> type[DevelopmentRun]:
        """See ``DevelopmentConfig``."""
        if self.resolution == "growing":
            return GrowingRun
        return ContinuousRun if self.maps == "continuous" else RenderedRun

    def new_run(self) -> DevelopmentRun:
        """A run before its first step; the robot has been calibrated, and has explored or babbled."""
        last = self.seed, self.steps
        initial = self.initial_modules()
        if self.resolution == "growing":
            body = FreeGazeBody if self.babbling.images else RecallingBody
            babbling = Babbling(self.table, self._growing(), self.seed, body)
            babbling.advance(self.babbling.steps)
            return GrowingRun(babbling, self.agent, *last, initial, self.sample_every)
        if self.maps == "continuous":
            world = self.table, self.rendered, self.agent
            return ContinuousRun(*world, *last, self.continuous, initial, self.sample_every)
        return RenderedRun(self.table, self.rendered, self.agent, *last, initial, self.sample_every)

    def _growing(self) -> GrowingConfig:
        world, babbling = self.rendered, self.babbling
        return GrowingConfig(
            stage=world.stage,
            senses=world.senses,
            resolution=babbling.resolution,
            calibration=world.calibration,
            exploration=world.exploration,
            face_share=babbling.face_share,
            margin=babbling.margin,
        )

    def film(self, path: Path, moments: Iterable[DevelopmentRun]) -> None:
        """Film some steps from each of a run's ``moments`` on."""
        with GrowthFilm(path) if self.resolution == "growing" else RunFilm(path) as film:
            for run in moments:
                made = meanings(run.named_variables(), run.agent.modules)
                title = f"After {made[-1].label}" if made else "Before the first module"
                if isinstance(film, GrowthFilm):
                    assert isinstance(run, GrowingRun)
                    film.growth(run, run.resolution, title, _driven, n_steps=12)
                    run.body.stage.world.close()
                else:
                    assert isinstance(run, RenderedRun)
                    film.scene(run, title)
                    run.close()


@dataclass(frozen=True)
class RenderedDevelopmentOptions(DevelopmentOptions):
    """Where a run leaves its results."""

    checkpoint_every: Every = RenderedDevelopmentConfig.checkpoint_every
    """Steps between checkpoints; a kill loses no more than these."""
    video: bool = False
    """Film some steps at the start and after each module, and leave a video."""


def _driven(run: GrowingRun) -> list[str]:
    """What the film of growing resolution says beside the images: what moved the gaze, and the modules by name."""
    made = [meaning.label for meaning in meanings(run.named_variables(), run.agent.modules)]
    driver = int(run.agent.state.driver[0])
    mover = made[driver] if 0 <= driver < len(made) else "at random"
    return [f"Moves the gaze: {mover}", f"Modules: {', '.join(made) or 'none yet'}"]
