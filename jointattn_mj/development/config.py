"""Options that a run has in every world, and options that follow from a preset unless they are given."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from jointattn_mj.contingency.online.reactive import AvoidingModule, CuriousModule, RandomModule, ReactiveModule
from jointattn_mj.development.agent import DeveloperConfig
from jointattn_mj.development.loop import DevelopmentRun
from jointattn_mj.development.meaning import CAREGIVER, GAZE
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.development.table.world import TableConfig
from jointattn_mj.errors import ConfigError
from jointattn_mj.options import Checked, Choice, Seed, Whole, changed, check_argument, meant, shown, with_new_names

Every = Annotated[int, Whole("[1, 1e10]")]
WORLDS = {
    "table": ("jointattn_mj.development.table.config", "TableDevelopmentConfig"),
    "rendered": ("jointattn_mj.development.rendered.config", "RenderedDevelopmentConfig"),
    "realtime": ("jointattn_mj.development.realtime.config", "RealtimeDevelopmentConfig"),
}
"""Module and class of each world's config; those with a 3D world take a second to import."""


@dataclass(frozen=True)
class DevelopmentConfig(Checked):
    """Options of a run; the same options give the same run. Each world has a class of its own."""

    world: Literal["table", "rendered", "realtime"]
    """Where the robot develops."""
    preset: Annotated[str, Choice(PRESETS)] = "thesis"
    """Reading of the text that gives --table.* and --agent.* their defaults; each option can still be set by itself.
    thesis: chapter 5 as it is written. thesis_robot_first: the robot acts first in a step. fast: makes the same modules
    in a fraction of the steps, by standard errors. local: in fewer still, by what is contingent where it holds, with
    curious gaze. chapter4: finds events and makes no modules."""
    steps: Annotated[int, Whole("[1, 1e10]")] = 100_000
    """Length of the run in steps. In a step the caregiver shifts gaze, the robot observes, and the robot acts."""
    seed: Seed = 0
    """Random seed of table, caregiver and robot."""
    reactive: Literal["random", "face_avoiding", "curious"] = "random"
    """Initial module of the gaze. random: shifts at random. face_avoiding: shifts that mostly avoid the caregiver (a
    model of autism, section 5.4). curious: each target as often as what is sensed there is hard to foresee."""
    sample_every: Annotated[int, Whole("[1, 1e10]")] = 100
    """Log the contingency of every event every N steps."""
    table: TableConfig = field(default_factory=TableConfig)
    agent: DeveloperConfig = field(default_factory=DeveloperConfig)

    RENAMED: ClassVar[Mapping[str, str]] = {"mind": "agent"}
    CHOOSES: ClassVar[tuple[tuple[str, str], ...]] = ()
    """Options besides the preset, and their values, from which the defaults of others follow."""
    steps_at_a_time: ClassVar[int]
    """Steps from one call of ``progress`` to the next."""
    checkpoint_every: ClassVar[int]
    """Steps between checkpoints, where the options do not say."""
    unit: ClassVar[str] = "steps"
    """Unit of ``length`` and of ``DevelopmentRun.spent``."""

    @classmethod
    def of(cls, **given: Any) -> Self:
        """A config in which the options that are not given follow from those that are, such as the preset.

        Args:
            given: Options by name; a group as a mapping of its options, such as ``table={"spots": 4}``, or whole.

        Raises:
            ConfigError: No such option, or a value that is not allowed.
        """
        named = with_new_names(cls, given)
        return changed(cls.defaults(named), named)

    @classmethod
    def defaults(cls, given: Mapping[str, Any]) -> Self:
        """The config before the options that are ``given`` replace its own.

        Raises:
            ConfigError: There is no such preset.
        """
        name = given.get("preset", cls.preset)
        check_argument("preset", name, Annotated[str, Choice(PRESETS)])
        preset = PRESETS[name]
        chosen: dict[str, Any] = {"table": preset.world, "agent": preset.agent, "reactive": preset.reactive}
        return cls(preset=name, **chosen)

    @property
    def kind(self) -> type[DevelopmentRun]:
        """Class of the run, as a checkpoint holds it."""
        raise self._of_no_world()

    @property
    def films(self) -> bool:
        """Whether a run can be filmed."""
        return False

    @property
    def length(self) -> float:
        """Length of the run, in ``unit``."""
        return self.steps

    def initial_modules(self) -> tuple[ReactiveModule, ...]:
        """The reactive module of the gaze; the gesture always moves at random."""
        if self.reactive == "curious":
            return (CuriousModule(GAZE),)
        return (RandomModule(GAZE) if self.reactive == "random" else AvoidingModule(GAZE, CAREGIVER),)

    def new_run(self) -> DevelopmentRun:
        """A run before its first step."""
        raise self._of_no_world()

    def film(self, path: Path, moments: Iterable[DevelopmentRun]) -> None:
        """Film some steps from each of a run's ``moments`` on, which may be used up."""
        raise ConfigError(f"a run in world {self.world} cannot be filmed; choose world rendered, or no video")

    def _of_no_world(self) -> NotImplementedError:
        return NotImplementedError(f"{type(self).__name__} is of no world; choose that of the table, say")


@dataclass(frozen=True)
class UnfilmedOptions(Checked):
    """Where a run leaves its results, in a world without films."""

    out: Path
    """Folder for the results. It is made when missing, and refused when it holds another run."""
    resume: bool = False
    """Go on from the checkpoint in the folder, to the same final result."""
    checkpoint_every: Every | None = None
    """Steps between checkpoints; a kill loses no more than these. None: what suits the world."""

    @property
    def video(self) -> bool:
        """Whether a video is left."""
        return False


@dataclass(frozen=True)
class DevelopmentOptions(UnfilmedOptions):
    """Where a run leaves its results, whatever its world."""

    video: bool = False
    """Film some steps at the start and after each module, and leave a video (world rendered only)."""


def config_class(world: str) -> type[DevelopmentConfig]:
    """The class of the options of a world.

    Args:
        world: One of ``WORLDS``.

    Raises:
        ConfigError: There is no such world.
    """
    check_world(world)
    module, name = WORLDS[world]
    kind: type[DevelopmentConfig] = getattr(import_module(module), name)
    return kind


def check_world(world: str) -> None:
    """Refuse a world that there is not.

    Raises:
        ConfigError: It is none of ``WORLDS``.
    """
    if not isinstance(world, str) or world not in WORLDS:
        raise ConfigError(f"world: expected one of {', '.join(WORLDS)}; got {shown(world)}{meant(world, WORLDS)}")
