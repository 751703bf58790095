"""``jointattn develop``: a mind and its table through a whole life, in a folder: progress, checkpoints, results."""

import json
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from jointattn_mj.contingency.online.reactive import AvoidingModule, RandomModule, ReactiveModule
from jointattn_mj.development.agent import DeveloperConfig
from jointattn_mj.development.behaviour import BehaviourLog, phases
from jointattn_mj.development.loop import DevelopmentRun, Found
from jointattn_mj.development.meaning import CAREGIVER, GAZE, Meaning, meanings
from jointattn_mj.development.summary import summarise
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.development.table.run import TableRun
from jointattn_mj.development.table.world import TableConfig
from jointattn_mj.errors import ConfigError
from jointattn_mj.io import checkpoint
from jointattn_mj.io.files import claimed, write_whole
from jointattn_mj.io.interrupts import deferred
from jointattn_mj.io.provenance import write_config
from jointattn_mj.io.rows import forget_log, log_folder, summary_of_ended
from jointattn_mj.io.space import check_free
from jointattn_mj.options import Checked, Choice, Seed, Whole

LIKELY_MODULES = 8
"""For an estimate of the space that will be needed: few lives find more."""


@dataclass(frozen=True)
class DevelopConfig(Checked):
    """What makes a life: the same config, the same life."""

    world: Literal["table", "rendered"] = "table"
    """Where the robot lives: at a table with spots, objects and a caregiver, in turns (chapters 4 and 5), which is
    told to it (table) or which it sees (rendered; --world rendered --help lists the options that come with it)."""
    preset: Annotated[str, Choice(PRESETS)] = "thesis"
    """A reading of the text that gives --table.* and --mind.* their defaults; each can still be set by itself. thesis:
    chapter 5 as it is written. thesis_robot_first: the robot acts first in a turn. fast: finds the same in a fraction
    of the turns, by standard errors. chapter4: finds, and makes no modules."""
    steps: Annotated[int, Whole("[1, 1e10]")] = 100_000
    """Turns to live."""
    seed: Seed = 0
    """Random seed of table, caregiver and robot."""
    reactive: Literal["random", "face_avoiding"] = "random"
    """What the robot is born with: random movements, or with few looks at the caregiver (a model of autism, section
    5.4)."""
    sample_every: Annotated[int, Whole("[1, 1e10]")] = 100
    """Turns between two notes of every event's contingency."""
    table: TableConfig = field(default_factory=TableConfig)
    agent: DeveloperConfig = field(default_factory=DeveloperConfig)

    RENAMED: ClassVar = {"mind": "agent"}

    kind: ClassVar[type[DevelopmentRun]] = TableRun
    """Of the life that it makes."""
    at_a_time: ClassVar[int] = 20_000
    """Turns between two looks at the bar and at Ctrl-C."""
    checkpoint_every: ClassVar[int] = 2_000_000
    """Turns between checkpoints, unless options say otherwise."""
    films: ClassVar[bool] = False
    """Whether there is anything to be filmed."""
    unit: ClassVar[str] = "turns"
    """Of ``DevelopmentRun.spent``."""

    @classmethod
    def of(cls, preset: str) -> "DevelopConfig":
        """The config that a preset stands for.

        Raises:
            ConfigError: There is no such preset.
        """
        if preset not in PRESETS:
            return cls(preset=preset)  # which says so
        return cls(preset=preset, table=PRESETS[preset].world, agent=PRESETS[preset].agent)

    def initial_modules(self) -> tuple[ReactiveModule, ...]:
        """The reactive module of the gaze; the gesture moves at random in any case."""
        return (RandomModule(GAZE) if self.reactive == "random" else AvoidingModule(GAZE, CAREGIVER),)

    @property
    def length(self) -> float:
        """How long the life is to last, in ``unit``."""
        return self.steps

    def film(self, path: Path, moments: Iterable[DevelopmentRun]) -> None:
        """Film some turns from each of a life's moments on, which may be used up."""
        raise ConfigError(f"a life in world {self.world} cannot be filmed; choose --world rendered")

    def new_run(self) -> DevelopmentRun:
        """A life before its first turn."""
        return TableRun(self.table, self.agent, self.seed, self.steps, self.initial_modules(), self.sample_every)


@dataclass(frozen=True)
class DevelopOptions(Checked):
    """Where a life leaves its results."""

    out: Path
    """Folder for the results; made when missing, refused when it holds another run."""
    resume: bool = False
    """Go on from the checkpoint in the folder, to the same final result."""
    checkpoint_every: Annotated[int, Whole("[1, 1e10]")] | None = None
    """Turns between checkpoints: at most so much is lost by a kill. None: 2,000,000, or 10,000 of a rendered world."""
    video: bool = False
    """Film some turns before, and after each module (world rendered only), and leave a video."""


def preset_in(arguments: Sequence[str], default: str = "thesis") -> str:
    """The preset that a command line names, since other defaults follow from it; ``default`` where it names none."""
    return _named_in(arguments, "--preset", PRESETS) or default


def world_in(arguments: Sequence[str]) -> str:
    """The world that a command line names, since options follow from it; ``table`` where it names none."""
    return _named_in(arguments, "--world", ("table", "rendered")) or "table"


def mode_in(arguments: Sequence[str]) -> str:
    """How time goes on in the rendered world that a command line names; ``n_steps`` where it does not say."""
    return _named_in(arguments, "--mode", ("turns", "realtime")) or "turns"


def _named_in(arguments: Sequence[str], option: str, names: Collection[str]) -> str | None:
    for before, argument in zip(["", *arguments], arguments, strict=False):
        name = argument.removeprefix(f"{option}=")
        if (before == option or name != argument) and name in names:
            return name
    return None


def run_development(
    config: DevelopConfig,
    options: DevelopOptions,
    progress: Callable[[DevelopmentRun, Sequence[tuple[Found, Meaning | None]]], object] = lambda run, found: None,
) -> dict[str, Any]:
    """Live a life and leave its results in ``options.out``; returns the summary.

    ``progress`` is called every ``config.at_a_time`` turns with what was found in them and what it means. On Ctrl-C or
    SIGTERM a checkpoint is written before KeyboardInterrupt goes on.

    Raises:
        ConfigError: The life's log would not fit onto the disk, or its options do not go together.
        OutputError: The folder holds another run, or cannot be written.
        CheckpointError: ``resume`` without a fitting checkpoint.
        NotFiniteError: What is learned or simulated has become NaN; the last checkpoint stays.
    """
    if not options.resume:
        check_space(config, options.out)
    if options.video and not config.films:
        raise ConfigError(f"world {config.world} has nothing to be filmed; choose --world rendered, or no --video")
    with claimed(options.out, options.resume):
        return _run(config, options, progress)


def _run(
    config: DevelopConfig,
    options: DevelopOptions,
    progress: Callable[[DevelopmentRun, Sequence[tuple[Found, Meaning | None]]], object],
) -> dict[str, Any]:
    """Live a life in a folder that is held for it."""
    out, frozen = options.out, options.out / "checkpoint.bin"
    every = options.checkpoint_every or config.checkpoint_every
    if options.resume:
        run: DevelopmentRun = checkpoint.load(frozen, config, kind=config.kind)
        if (summary := summary_of_ended(out)) is not None:
            _forget_moments(out)
            return summary
        run.attach(log_folder(out))
    else:
        run = config.new_run()
        run.attach(log_folder(out))
        if options.video:
            _keep(_moment(out, 0), run, config)
        _keep(frozen, run, config)
    if not (out / "config.yaml").exists():
        write_config(out / "config.yaml", config)
    with deferred() as interrupts:
        while run.spent < config.length and run.steps_done < run.n_steps:
            pause = min(run.n_steps, (run.steps_done // every + 1) * every)
            found = run.advance(min(config.at_a_time, pause - run.steps_done))
            if options.video and found and run.agent.modules:
                _keep(_moment(out, len(run.agent.modules)), run, config)
            progress(run, _with_meanings(run, found))
            if run.steps_done == pause or interrupts.requested:
                _keep(frozen, run, config)
            if interrupts.requested:
                raise KeyboardInterrupt
    if options.video:
        kept = sorted(out.glob("moment_*.bin"))
        config.film(out / "video.mp4", (_recalled(path, config, out) for path in kept))
    run.check()
    summary = _leave_results(config, run, out)
    _forget_moments(out)
    return summary


def _keep(path: Path, run: DevelopmentRun, config: DevelopConfig) -> None:
    run.check()
    checkpoint.save(path, run, config)


def _moment(out: Path, modules: int) -> Path:
    """Where a life is kept as it was with so many modules, to be filmed at the end."""
    return out / f"moment_{modules:02d}.bin"


def _forget_moments(out: Path) -> None:
    """Delete them when the results are complete: a run that is killed before films them again."""
    for path in out.glob("moment_*.bin"):
        path.unlink()


def _recalled(path: Path, config: DevelopConfig, out: Path) -> DevelopmentRun:
    """A life as it was at some moment, with its log in memory: what it lives from there on is nobody's result."""
    run: DevelopmentRun = checkpoint.load(path, config, kind=config.kind)
    run.recall(log_folder(out))
    return run


def check_space(config: DevelopConfig, out: Path) -> None:
    """Refuse a life whose log would not fit onto the disk.

    Raises:
        ConfigError: It would not.
    """
    log = 16 * config.steps  # first as rows, then as Parquet as well
    modules = min(LIKELY_MODULES, config.agent.most_modules)
    samples = 2 * 8 * 3 * (2 + modules) ** 2 * (config.steps // config.sample_every)
    what = f"--steps {config.steps}"
    check_free(out, log + samples, what, f"fewer --steps{', or a larger --sample-every' if samples > log else ''}")


def _with_meanings(run: DevelopmentRun, found: Sequence[Found]) -> list[tuple[Found, Meaning | None]]:
    if not found:
        return []
    known = dict(zip((id(module) for module in run.agent.modules), _meanings(run), strict=True))
    return [(one, known.get(id(one.module))) for one in found]


def _meanings(run: DevelopmentRun) -> list[Meaning]:
    return meanings(run.named_variables(), run.agent.modules)


def _leave_results(config: DevelopConfig, run: DevelopmentRun, out: Path) -> dict[str, Any]:
    from jointattn_mj.development import figures, logbook  # bring matplotlib and pyarrow, which take a second to import

    agent, variables = run.agent, run.named_variables()
    found = BehaviourLog(run)
    made = [one for one in run.found if one.module is not None]
    parts = phases(found, [one.step for one in made])
    known = _meanings(run)
    marks = [
        figures.Made(one.step, agent.events.index(one.event), meaning.label)
        for one, meaning in zip(made, known, strict=True)
    ]
    names = [variables.describe(event) for event in agent.events]
    detector = agent.config.detector
    unit = "bits" if detector.base == 2 else f"units of base {detector.base:g}"
    measure = f"{'SAC' if detector.measure == 'sac' else 'T^C'} ({unit})"
    figures.draw_contingency(out / "sac.png", run.noted, names, marks, measure)
    figures.draw_behaviour(out / "behaviour.png", found, parts, marks)
    figures.draw_maps(
        out / "maps.png",
        [
            figures.MapImage(f"{number}: {mark.label}", module, variables)
            for number, (mark, module) in enumerate(zip(marks, agent.modules, strict=True), 1)
        ],
    )
    logbook.write_steps(out / "turns.parquet", run)
    logbook.write_contingency(out / "contingency.parquet", run)
    for number, module in enumerate(agent.modules, 1):
        logbook.write_map(out / f"module_{number}.csv", variables, module)
    summary = {
        "world": config.world,
        "preset": config.preset,
        "seed": config.seed,
        **summarise(run, known, parts),
        **run.more(),
    }
    text = json.dumps(summary, indent=1, ensure_ascii=False) + "\n"
    write_whole(out / "summary.json", lambda path: path.write_text(text, "utf-8"))
    forget_log(out)
    return summary
