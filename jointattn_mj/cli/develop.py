"""``jointattn develop table|rendered|realtime``: shows how the run goes, and names each module as it is made."""

import argparse
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any

from jointattn_mj.cli.given import typed_only
from jointattn_mj.cli.help import HELP
from jointattn_mj.cli.parsing import config_from, with_defaults
from jointattn_mj.cli.running import going_on_from, one_thread
from jointattn_mj.development.config import (
    DevelopmentConfig,
    UnfilmedOptions,
    check_world,
    config_class,
)
from jointattn_mj.development.loop import Detection, DevelopmentRun
from jointattn_mj.development.meaning import Meaning
from jointattn_mj.development.run import run_development
from jointattn_mj.development.summary import DevelopmentSummary
from jointattn_mj.development.table.config import TableDevelopmentConfig, TableDevelopmentOptions
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.errors import ConfigError
from jointattn_mj.io.progress import Progress, count
from jointattn_mj.options import FLAT, changed, warn_renamed

LESS = "fewer steps or minutes, or a shorter `--agent.horizon`"


def develop() -> None:
    """Let a robot find what is contingent, make modules of it, and so develop joint attention (chapters 4, 5, 7).

    Choose a WORLD; jointattn develop WORLD --help has its options:

    * table: at a table with spots, objects and a caregiver, whose state the robot is told in symbols (the default).
    * rendered: at the same table, which the robot sees in rendered images, one a step.
    * realtime: the same at 30 frames a second; the caregiver does not wait for the robot.

    Leaves in --out: config.yaml, summary.json (modules in their order, what they mean, behaviour by phases),
    sac.png and behaviour.png (Fig. 5.3 and 5.5), maps.png, module_1.csv and so on (the learned maps), steps.parquet
    with a row a step, contingency.parquet, checkpoint.bin, and in world rendered with --video a video.
    """


def table(config: Annotated[TableDevelopmentConfig, FLAT], options: Annotated[TableDevelopmentOptions, FLAT]) -> None:
    """Develop at a table with spots, objects and a caregiver, whose state the robot is told in symbols."""
    run_with_bar(config, options)


def _rendered() -> Callable[..., None]:
    from jointattn_mj.development.rendered.config import (  # the 3D world: a second to import
        RenderedDevelopmentConfig,
        RenderedDevelopmentOptions,
    )

    def rendered(
        config: Annotated[RenderedDevelopmentConfig, FLAT], options: Annotated[RenderedDevelopmentOptions, FLAT]
    ) -> None:
        """Develop at a table that the robot sees in rendered images, one a step; bodies are imprecise.

        --maps continuous and --resolution growing do what section 7.1 asks for.
        """
        one_thread()
        run_with_bar(config, options)

    return rendered


def _realtime() -> Callable[..., None]:
    from jointattn_mj.development.realtime.config import RealtimeDevelopmentConfig, RealtimeDevelopmentOptions

    def realtime(
        config: Annotated[RealtimeDevelopmentConfig, FLAT], options: Annotated[RealtimeDevelopmentOptions, FLAT]
    ) -> None:
        """Develop at the same table at 30 frames a second; the caregiver does not wait for the robot."""
        one_thread()
        run_with_bar(config, options)

    return realtime


def command_for(arguments: Sequence[str], file: Path | None) -> tuple[Callable[..., None], list[str]]:
    """The command of a world, and the words that follow it.

    Args:
        arguments: What follows ``jointattn develop``.
        file: That of --config, whose options come in the place of those of a preset.

    Raises:
        ConfigError: There is no such world, or the file holds no config of it.
    """
    if arguments[:1] and arguments[0] in HELP:
        return develop, list(arguments)
    world, *words = with_world(arguments)
    makers = {"table": lambda: table, "rendered": _rendered, "realtime": _realtime}
    kind = config_class(world)
    if file is None:
        default = typed_only(kind.defaults({}), variants_of(kind), kind.of)
    else:
        start = config_from(file, kind, f"develop {world}")
        default = typed_only(start, {"": start}, lambda **given: _changed(start, given))
    return with_defaults(makers[world](), config=default), words


def variants_of(kind: type[DevelopmentConfig]) -> dict[str, DevelopmentConfig]:
    """The defaults of a world's options by the choices that they follow from; first where nothing is chosen."""
    start = kind.defaults({})
    variants = {name: kind.defaults({"preset": name}) for name in (start.preset, *PRESETS)}
    for name, value in kind.CHOOSES:
        variants[f"--{name} {value}"] = kind.defaults({name: value})
    return variants


def _changed(start: DevelopmentConfig, given: dict[str, Any]) -> DevelopmentConfig:
    """The config of a file with the options that were typed.

    Raises:
        ConfigError: One of them chooses defaults, which the file has already.
    """
    for name in ("preset", *dict(start.CHOOSES)):
        if given.get(name, getattr(start, name)) != getattr(start, name):
            raise ConfigError(
                f"--{name} {given[name]} chooses other defaults than the file of --config, which holds them all; give "
                "one of the two"
            )
    return changed(start, given)


def with_world(arguments: Sequence[str]) -> list[str]:
    """What follows ``jointattn develop``, beginning with the world; without any it is ``table``.

    What the last version had in its place is taken for one version more, with a warning: ``--world rendered --mode
    realtime`` for ``realtime``.

    Raises:
        ConfigError: There is no such world.
    """
    if arguments[:1] == ["help"]:
        raise ConfigError("for help: jointattn develop --help")
    if arguments[:1] and not arguments[0].startswith("-"):
        check_world(arguments[0])
        return list(arguments)
    old = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    old.add_argument("--world", nargs="?")
    old.add_argument("--mode", nargs="?")
    named, words = old.parse_known_args(arguments)
    world = (named.mode if named.mode not in (None, "turns") else named.world) or "table"
    check_world(world)
    if named.world or named.mode:
        given = [f"--{name} {value}" for name, value in vars(named).items() if value]
        warn_renamed(f"develop {' '.join(given)}", f"develop {world}")
    return [world, *words]


def run_with_bar(config: DevelopmentConfig, options: UnfilmedOptions) -> None:
    """Run, show on stderr how it goes, and say on stdout what came of it."""
    started = time.perf_counter()
    shown = Progress("exploring" if config.world != "table" else "developing", config.length, config.unit)

    def progress(run: DevelopmentRun, detections: Sequence[tuple[Detection, Meaning | None]]) -> None:
        for detection, meaning in detections:
            if meaning is not None:
                event = run.agent.variables.describe(detection.event)
                shown.say(f"step {detection.step:,}: {meaning.label}  [{event}]")
        shown.doing("developing")
        shown.to(run.spent, count(len(run.agent.modules), "module"))

    with going_on_from(options.out, "the run"), shown:
        result = run_development(config, options, progress)
    print(text(result.summary))
    print(f"In {time.perf_counter() - started:.1f} s. Results: {options.out}")


def text(summary: DevelopmentSummary) -> str:
    """The modules in their order, to read."""
    lines = [f"{'step':>10}  {'event':48}  what it means"] if summary.modules else ["No module was made."]
    for module in summary.modules:
        name = f" ({module.name})" if module.name.endswith("-m") else ""
        lines.append(f"{module.step:>10,}  {module.event:48}  {module.means}{name}")
    lines += [
        f"{event.step:>10,}  {event.event:48}  found, no module made" for event in summary.detected_without_a_module
    ]
    return "\n".join(lines)
