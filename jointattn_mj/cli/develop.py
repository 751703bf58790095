"""``jointattn develop table|rendered|realtime``: shows how the run goes, and names each module as it is made."""

import argparse
import re
import sys
import time
from collections.abc import Callable, Sequence
from functools import reduce
from operator import or_
from typing import Annotated, Any

import tyro

from jointattn_mj.cli.given import given_type
from jointattn_mj.development.config import DevelopmentConfig, DevelopmentOptions
from jointattn_mj.development.loop import DevelopmentRun, Found
from jointattn_mj.development.meaning import Meaning
from jointattn_mj.development.run import WORLDS, check_world, config_class, run_development
from jointattn_mj.development.summary import DevelopmentSummary
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.io.notices import notice
from jointattn_mj.io.progress import Progress, count

OPTIONS = Annotated[DevelopmentOptions, tyro.conf.arg(name="")]


def develop(arguments: Sequence[str] = ()) -> Callable[..., Any]:
    """The command for tyro to parse. Of a world that ``arguments`` do not name nothing is imported."""
    makers = {"table": _table, "rendered": _rendered, "realtime": _realtime}
    asked = [world for world in WORLDS if world in arguments[1:2]] or WORLDS
    worlds = [Annotated[Any, tyro.conf.subcommand(world, constructor=makers[world]())] for world in asked]
    worlds.append(Annotated[None, tyro.conf.Suppress])  # tyro's sub-commands are a union of two types or more
    union: Any = reduce(or_, worlds)

    def command(run: Annotated[union, tyro.conf.arg(name="")]) -> Callable[[], None]:
        """Let a robot find what is contingent, make modules of it, and so develop joint attention (chapters 4, 5, 7).

        Leaves in --out: config.yaml, summary.json (modules in their order, what they mean, behaviour by phases),
        sac.png (Fig. 5.3), behaviour.png (Fig. 5.5), maps.png, module_1.csv and so on (the learned maps), steps.parquet
        (a row a step), contingency.parquet, checkpoint.bin, and with --video a video.
        """
        started: Callable[[], None] = run
        return started

    return command


def _table() -> Callable[..., Any]:
    def table(given: _given("table"), options: OPTIONS) -> Callable[[], None]:  # type: ignore[valid-type]
        """At a table with spots, objects and a caregiver, whose state the robot is told in symbols."""
        return _start("table", given, options)

    return table


def _rendered() -> Callable[..., Any]:
    def rendered(given: _given("rendered"), options: OPTIONS) -> Callable[[], None]:  # type: ignore[valid-type]
        """At the same table, which the robot sees in rendered images, one a step; bodies are imprecise.

        --maps continuous and --resolution growing choose what section 7.1 asks for.
        """
        return _start("rendered", given, options)

    return rendered


def _realtime() -> Callable[..., Any]:
    def realtime(given: _given("realtime"), options: OPTIONS) -> Callable[[], None]:  # type: ignore[valid-type]
        """At the same table at 30 frames a second; the caregiver does not wait for the robot."""
        return _start("realtime", given, options)

    return realtime


def _given(world: str) -> Any:
    """What tyro parses the options of a world to; help says which defaults follow from which options."""
    kind = config_class(world)
    names = [kind.defaults({}).preset, *PRESETS]
    defaults: dict[str, DevelopmentConfig] = {name: kind.defaults({"preset": name}) for name in names}
    if world == "rendered":
        defaults["--maps continuous"] = kind.defaults({"maps": "continuous"})
        defaults["--resolution growing"] = kind.defaults({"resolution": "growing"})
    return Annotated[given_type(kind, defaults, ("world",)), tyro.conf.arg(name="")]


def _start(world: str, given: dict[str, Any], options: DevelopmentOptions) -> Callable[[], None]:
    config = config_class(world).of(**given)
    return lambda: run_with_bar(config, options)


def with_world(arguments: Sequence[str]) -> list[str]:
    """Arguments of ``jointattn develop`` with the sub-command that they mean; without any it is ``table``.

    What the last version had in its place is taken for one version more, with a warning: ``--world rendered --mode
    realtime`` for ``realtime``, and ``--mind.*`` for ``--agent.*``.

    Raises:
        ConfigError: There is no such world.
    """
    first = arguments[1] if len(arguments) > 1 else ""
    if arguments[:1] != ["develop"] or first in ("-h", "--help", "--help-all"):
        return list(arguments)
    if first and not first.startswith("-"):
        check_world(first)
        return list(arguments)
    old = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    old.add_argument("--world", nargs="?")
    old.add_argument("--mode", nargs="?")
    named, rest = old.parse_known_args(arguments[1:])
    world = (named.mode if named.mode not in (None, "turns") else named.world) or "table"
    check_world(world)
    current = [re.sub(r"^--mind(?=[.=])", "--agent", argument) for argument in rest]
    if named.world or named.mode:
        notice(f"warning: --world and --mode are now a sub-command: jointattn develop {world}; they go soon")
    if current != rest:
        notice("warning: --mind.* is now called --agent.*; the old name goes with the next version")
    return ["develop", world, *current]


def run_with_bar(config: DevelopmentConfig, options: DevelopmentOptions) -> None:
    """Run, show on stderr how it goes, and say on stdout what came of it."""
    started = time.perf_counter()
    shown = Progress(
        "beginning" if options.resume or config.world == "table" else "exploring", config.length, config.unit
    )

    def progress(run: DevelopmentRun, found: Sequence[tuple[Found, Meaning | None]]) -> None:
        for one, meaning in found:
            if meaning is not None:
                shown.say(f"step {one.step:,}: {meaning.label}  [{run.agent.variables.describe(one.event)}]")
        shown.doing("developing")
        shown.to(run.spent, count(len(run.agent.modules), "module"))

    try:
        with shown:
            result = run_development(config, options, progress)
    except KeyboardInterrupt:
        if (options.out / "checkpoint.bin").exists():
            print(f"jointattn: stopped; the same command with --resume goes on from {options.out}", file=sys.stderr)
        else:
            print("jointattn: stopped before the first step; nothing was written", file=sys.stderr)
        raise
    print(text(result.summary))
    print(f"In {time.perf_counter() - started:.1f} s. Results: {options.out}")


def text(summary: DevelopmentSummary) -> str:
    """The modules in their order, to read."""
    lines = [f"{'step':>10}  {'event':48}  what it means"] if summary.modules else ["No module was made."]
    for one in summary.modules:
        name = f" ({one.name})" if one.name.endswith("-m") else ""
        lines.append(f"{one.step:>10,}  {one.event:48}  {one.means}{name}")
    lines += [f"{one.step:>10,}  {one.event:48}  found, no module made" for one in summary.found_without_a_module]
    return "\n".join(lines)
