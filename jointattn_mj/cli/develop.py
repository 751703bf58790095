"""``jointattn develop``, which shows how it goes and names each module as it is found."""

import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any

from jointattn_mj.cli.parsing import with_defaults
from jointattn_mj.development.loop import DevelopmentRun, Found
from jointattn_mj.development.meaning import Meaning
from jointattn_mj.development.run import DevelopConfig, DevelopOptions, mode_in, preset_in, run_development, world_in
from jointattn_mj.io.configs import read_config
from jointattn_mj.io.progress import Progress, count
from jointattn_mj.options import FLAT

LESS = "fewer steps or minutes"


def develop(config: Annotated[DevelopConfig, FLAT], options: Annotated[DevelopOptions, FLAT]) -> None:
    """Let a robot find what is contingent, make modules of it, and so develop joint attention (chapters 4 and 5).

    Leaves in --out: config.yaml, summary.json (modules in their order, what they mean, behaviour by phases),
    sac.png (Fig. 5.3), behaviour.png (Fig. 5.5), maps.png, module_1.csv and so on (the learned maps),
    turns.parquet (a row a turn), contingency.parquet, checkpoint.bin, and with --video a video. The defaults below
    are those of --preset and --world.
    """
    run_with_bar(config, options)


def command_for(arguments: Sequence[str], file: Path | None) -> Callable[..., None]:
    """The command with the defaults that --preset, --world and --mode stand for, or those of a file."""
    chosen = DevelopConfig.of(preset_in(arguments))
    if world_in(arguments) == "rendered":
        from jointattn_mj.development.realtime.config import RealtimeDevelopConfig
        from jointattn_mj.development.rendered.config import RenderedDevelopConfig

        kind = RealtimeDevelopConfig if mode_in(arguments) == "realtime" else RenderedDevelopConfig
        chosen = kind.of(preset_in(arguments, default="fast"))
    return with_defaults(develop, config=chosen if file is None else read_config(file, type(chosen)))


def run_with_bar(config: DevelopConfig, options: DevelopOptions) -> None:
    """Live a life, show on stderr how it goes, and say on stdout what came of it."""
    started = time.perf_counter()
    shown = Progress("developing", config.length, config.unit)

    def progress(run: DevelopmentRun, found: Sequence[tuple[Found, Meaning | None]]) -> None:
        for one, meaning in found:
            if meaning is not None:
                shown.say(f"turn {one.step:,}: {meaning.label}  [{run.agent.variables.describe(one.event)}]")
        modules = len(run.agent.modules)
        shown.to(run.spent, count(modules, "module"))

    try:
        with shown:
            summary = run_development(config, options, progress)
    except KeyboardInterrupt:
        if (options.out / "checkpoint.bin").exists():
            print(f"jointattn: stopped; the same command with --resume goes on from {options.out}", file=sys.stderr)
        else:
            print("jointattn: stopped before the life began; nothing was written", file=sys.stderr)
        raise
    print(text(summary))
    print(f"In {time.perf_counter() - started:.1f} s. Results: {options.out}")


def text(summary: dict[str, Any]) -> str:
    """The modules in their order, to read."""
    lines = [f"{'step':>10}  {'event':48}  what it means"] if summary["modules"] else ["No module was made."]
    for one in summary["modules"]:
        name = f" ({one['name']})" if one["name"].endswith("-m") else ""
        lines.append(f"{one['step']:>10,}  {one['event']:48}  {one['means']}{name}")
    lines += [
        f"{one['step']:>10,}  {one['event']:48}  found, no module made" for one in summary["found_without_a_module"]
    ]
    return "\n".join(lines)
