"""``jointattn develop``, and the same from Python: a run in memory, or in a folder with checkpoints and results."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any, Literal

from jointattn_mj.development.config import (
    DevelopmentConfig,
    DevelopmentOptions,
    UnfilmedOptions,
    config_class,
)
from jointattn_mj.development.loop import Detection, DevelopmentRun
from jointattn_mj.development.meaning import Meaning, meanings
from jointattn_mj.development.result import CONFIG, DevelopmentResult, Finished
from jointattn_mj.errors import ConfigError
from jointattn_mj.io import checkpoint
from jointattn_mj.io.files import claimed
from jointattn_mj.io.interrupts import deferred
from jointattn_mj.io.provenance import write_config
from jointattn_mj.io.rows import forget_log, log_folder, summary_of_ended
from jointattn_mj.io.space import check_free
from jointattn_mj.options import as_arguments, changed, check_argument, check_called, path_of

LIKELY_MODULES = 8
"""For an estimate of the space on disk: few runs make more modules."""
Progress = Callable[[DevelopmentRun, Sequence[tuple[Detection, Meaning | None]]], object]
"""Called now and then with the run, and with the events that were found since the last call and what they mean."""


@dataclass(frozen=True, init=False, repr=False)
class Development:
    """A robot that finds what is contingent, makes modules of it, and so develops joint attention (chapters 4, 5, 7).

    The options are those of ``jointattn develop table|rendered|realtime`` under the same names.

    Args:
        preset: ``"thesis"`` (chapter 5 as it is written), ``"thesis_robot_first"``, ``"fast"`` (the same modules in a
            fraction of the steps), ``"local"`` (in fewer still, within an hour of real time) or ``"chapter4"``; None:
            ``"thesis"`` at the table, else ``"fast"``.
        world: ``"table"``: the state of the table is told in symbols. ``"rendered"``: the robot sees it, an image a
            step. ``"realtime"``: the same at 30 frames a second; the caregiver does not wait.
        options: Any other option by name, such as ``steps``, ``seed``, ``reactive`` or, in real time, ``minutes``; a
            group as a mapping: ``table={"spots": 4}``.

    Attributes:
        config: All options, typed; each is an attribute of its own too, such as ``steps``. None can be set:
            ``replace(seed=2)`` gives another.

    Raises:
        ConfigError: No such option, or a value that is not allowed; the message says which are.

    Examples:
        >>> from jointattn_mj import Development
        >>> result = Development("fast", steps=6000, seed=1).run()
        >>> result.modules
        (<module 1: gaze following (FG-m), step 3,645>,)
        >>> result.maps[0].columns
        ('object', "caregiver's face", 'shift gaze', 'reliability', 'expected object')
    """

    config: DevelopmentConfig

    def __init__(
        self, preset: str | None = None, *, world: Literal["table", "rendered", "realtime"] = "table", **options: Any
    ):
        chosen = options if preset is None else {"preset": preset, **options}
        object.__setattr__(self, "config", config_class(world).of(**chosen))

    @classmethod
    def from_config(cls, config: DevelopmentConfig) -> "Development":
        """Make a development of a config that is already there.

        Args:
            config: All options, such as those of a result.

        Returns:
            The development; its ``run`` does what the config says.

        Raises:
            ConfigError: It is no such config.

        Examples:
            >>> from jointattn_mj import Development
            >>> config = Development("fast", steps=6000).config
            >>> Development.from_config(config).steps
            6000
        """
        check_argument("config", config, DevelopmentConfig)
        made = cls.__new__(cls)
        object.__setattr__(made, "config", config)
        return made

    def replace(self, **changes: Any) -> "Development":
        """The same with other values of some options; all others stay.

        Args:
            changes: Options by name, but for those from which others follow: world, preset, and in world rendered maps
                and resolution.

        Returns:
            Another development; this one stays as it is.

        Raises:
            ConfigError: No such option, or a value that is not allowed.

        Examples:
            >>> from jointattn_mj import Development
            >>> Development("fast", steps=6000).replace(seed=2)
            Development('fast', world='table', steps=6000, seed=2)
        """
        leading = "world", "preset", *dict(self.config.CHOOSES)
        if changes.keys() & set(leading):
            raise ConfigError(f"other options follow from {' and '.join(leading)}; make another Development with them")
        return self.from_config(changed(self.config, changes))

    def __getattr__(self, name: str) -> Any:
        """An option by its name, such as ``steps``."""
        if name != "config" and not name.startswith("_") and hasattr(self.config, name):
            return getattr(self.config, name)
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def run(
        self,
        out: str | PathLike[str] | None = None,
        *,
        resume: bool = False,
        checkpoint_every: int | None = None,
        video: bool = False,
        progress: Progress = lambda run, detections: None,
    ) -> DevelopmentResult:
        """Run to the end.

        Args:
            out: Folder for the results and checkpoints; None: nothing is written.
            resume: Go on from the checkpoint in ``out``, to the same final result.
            checkpoint_every: Steps between checkpoints; None: what suits the world.
            video: Also leave a video (world rendered only).
            progress: Called now and then with the run, and with what was found since the last call.

        Returns:
            The result; with ``out`` its tables are read from there when they are asked for.

        Raises:
            ConfigError: The log would not fit onto the disk, or options do not go together.
            OutputError: ``out`` holds another run, or cannot be written.
            CheckpointError: ``resume`` without a fitting checkpoint.
            NotFiniteError: Something learned or simulated has become NaN; the last checkpoint stays.
            GLError: Images are needed and cannot be rendered.

        Examples:
            >>> from jointattn_mj import Development
            >>> result = Development("chapter4", steps=500).run(out="out/chapter4")
            >>> sorted(path.name for path in result.folder.glob("*.parquet"))
            ['contingency.parquet', 'steps.parquet']
        """
        check_called("progress", progress)
        if out is not None:
            with as_arguments():
                options = DevelopmentOptions(path_of(out, "out"), resume, checkpoint_every, video)
            return run_development(self.config, options, progress)
        if resume or checkpoint_every is not None or video:
            raise ConfigError("resume, checkpoint_every and video need a folder; give out as well")
        run = self.config.new_run()
        for detections in _parts(self.config, run):
            progress(run, _with_meanings(run, detections))
        run.check()
        result = Finished(self.config, run).result()
        run.close()
        return result

    def __repr__(self) -> str:
        config = self.config
        length = f"steps={config.steps}" if config.unit == "steps" else f"minutes={config.length:g}"
        return f"Development({config.preset!r}, world={config.world!r}, {length}, seed={config.seed})"


def run_development(
    config: DevelopmentConfig, options: UnfilmedOptions, progress: Progress = lambda run, detections: None
) -> DevelopmentResult:
    """Run in a folder, with checkpoints.

    On Ctrl-C or SIGTERM a checkpoint is written before KeyboardInterrupt goes on.

    Args:
        config: What is run.
        options: The folder, and whether the run in it goes on.
        progress: Called every ``config.steps_at_a_time`` steps with what was found in them and what it means.

    Raises:
        ConfigError: The run's log would not fit onto the disk, or its options do not go together.
        OutputError: The folder holds another run, or cannot be written.
        CheckpointError: ``resume`` without a fitting checkpoint.
        NotFiniteError: Something learned or simulated has become NaN; the last checkpoint stays.
    """
    if not options.resume:
        check_space(config, options.out)
    if options.video and not config.films:
        raise ConfigError("only what is rendered can be filmed; choose world rendered with images, or no video")
    frozen = options.out / "checkpoint.bin"
    with claimed(options.out, options.resume), checkpoint.gone_on_with(frozen, options.resume, progress):
        return _run(config, options, progress)


def _run(config: DevelopmentConfig, options: UnfilmedOptions, progress: Progress) -> DevelopmentResult:
    """Run in a folder that is held for it."""
    out, frozen = options.out, options.out / "checkpoint.bin"
    every = options.checkpoint_every or config.checkpoint_every
    if options.resume:
        run: DevelopmentRun = checkpoint.load(frozen, config, kind=config.kind, check=partial(_check_length, config))
        if summary_of_ended(out) is not None:
            _forget_moments(out)
            return DevelopmentResult.open(out)
        run.attach(log_folder(out))
    else:
        run = config.new_run()
        run.attach(log_folder(out))
        if options.video:
            _keep(_moment(out, 0), run, config)
        _keep(frozen, run, config)
    if not (out / CONFIG).exists():
        write_config(out / CONFIG, config)
    with deferred() as interrupts:
        for detections in _parts(config, run, every):
            if options.video and detections and run.agent.modules:
                _keep(_moment(out, len(run.agent.modules)), run, config)
            progress(run, _with_meanings(run, detections))
            if run.steps_done in (run.n_steps, run.steps_done // every * every) or interrupts.requested:
                _keep(frozen, run, config)
            if interrupts.requested:
                raise KeyboardInterrupt
    if options.video:
        kept = sorted(out.glob("moment_*.bin"))
        config.film(out / "video.mp4", (_recalled(path, config, out) for path in kept))
    run.check()
    Finished(config, run).save(out)
    forget_log(out)
    _forget_moments(out)
    run.close()
    return DevelopmentResult.open(out)


def _check_length(config: DevelopmentConfig, run: DevelopmentRun) -> None:
    """Refuse a run from a checkpoint that is longer or shorter than the config says, or is noted at other steps.

    Raises:
        ValueError: It is.
    """
    for name, given in (("n_steps", config.steps), ("sample_every", config.sample_every)):
        if getattr(run, name) != given:
            raise ValueError(f"its {name} is {getattr(run, name)}, and under this config {given}")


def _parts(config: DevelopmentConfig, run: DevelopmentRun, every: int | None = None) -> Iterator[list[Detection]]:
    """Advance to the end in parts, which also end after each ``every`` steps; what was found in each."""
    while run.spent < config.length and run.steps_done < run.n_steps:
        pause = run.n_steps if every is None else min(run.n_steps, (run.steps_done // every + 1) * every)
        yield run.advance(min(config.steps_at_a_time, pause - run.steps_done))


def _keep(path: Path, run: DevelopmentRun, config: DevelopmentConfig) -> None:
    run.check()
    checkpoint.save(path, run, config)


def _moment(out: Path, modules: int) -> Path:
    """Where the run is kept as it was with so many modules, to be filmed at the end."""
    return out / f"moment_{modules:02d}.bin"


def _forget_moments(out: Path) -> None:
    """Delete them when the results are complete: a run that is killed before films them again."""
    for path in out.glob("moment_*.bin"):
        path.unlink()


def _recalled(path: Path, config: DevelopmentConfig, out: Path) -> DevelopmentRun:
    """The run as it was at some moment, with its log in memory; its further steps belong to no result."""
    run: DevelopmentRun = checkpoint.load(path, config, kind=config.kind)
    run.recall(log_folder(out))
    return run


def check_space(config: DevelopmentConfig, out: Path) -> None:
    """Refuse a run whose log would not fit onto the disk.

    Raises:
        ConfigError: It would not.
    """
    log = 16 * config.steps  # first as rows, then as Parquet as well
    modules = min(LIKELY_MODULES, config.agent.most_modules)
    samples = 2 * 8 * 3 * (2 + modules) ** 2 * (config.steps // config.sample_every)
    what = f"{config.steps:,} steps"
    check_free(out, log + samples, what, f"fewer steps{', or a larger `sample_every`' if samples > log else ''}")


def _with_meanings(run: DevelopmentRun, detections: Sequence[Detection]) -> list[tuple[Detection, Meaning | None]]:
    if not detections:
        return []
    known = zip(run.agent.modules, meanings(run.named_variables(), run.agent.modules), strict=True)
    by_module = {id(module): meaning for module, meaning in known}
    return [(detection, by_module.get(id(detection.module))) for detection in detections]
