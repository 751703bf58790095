"""``jointattn perceive``, which shows how it goes."""

import sys

from jointattn_mj.footage.config import PerceiveConfig, PerceiveOptions
from jointattn_mj.footage.reader import RATE
from jointattn_mj.footage.run import run_perceive
from jointattn_mj.footage.viewing import Viewing
from jointattn_mj.io.progress import Progress


def run_with_bar(config: PerceiveConfig, options: PerceiveOptions) -> None:
    """Watch the video, and say in a few lines what came of it; errors are :func:`footage.run.run_perceive`'s."""
    shown = Progress("going back to where it was" if options.resume else "looking for a face", unit="s of video")

    def progress(viewing: Viewing) -> None:
        found = viewing.visible / viewing.frames
        words = f"face in {found[-1]:.0%}, {len(viewing.fixations.all)} fixations"
        shown.doing("watching")
        shown.to(viewing.frames / RATE, words, _seconds(viewing))

    try:
        with shown:
            summary = run_perceive(config, options, progress)
    except KeyboardInterrupt:
        if (options.out / "summary.json").exists():
            left = f"what was watched is in {options.out}; the same command with --resume goes on"
        elif (options.out / "checkpoint.bin").exists():
            left = f"the same command with --resume goes on from {options.out}"
        else:
            left = "nothing was written"
        print(f"jointattn: stopped; {left}", file=sys.stderr)
        raise
    found = ", ".join(f"{name} {share:.0%}" for name, share in summary["found"].items())
    print(f"{summary['watched_seconds']:.1f} s watched. Found: {found}. {summary['fixations']} fixations.")
    for note in summary["notes"]:
        print(f"Note: {note}.")
    print(f"In {summary['wall_seconds']:.1f} s. Results: {options.out}")


def _seconds(viewing: Viewing) -> float | None:
    """How long the viewing will be, if anybody knows."""
    bounds = [bound for bound in (viewing.footage.declared_s, viewing.total / RATE) if bound is not None]
    least = min(bounds)
    return None if least == float("inf") else max(least, viewing.frames / RATE)
