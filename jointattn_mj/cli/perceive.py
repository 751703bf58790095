"""``jointattn perceive``: what the robot perceives in a video, and how far it has come."""

import sys
from typing import Annotated, Any

from jointattn_mj.cli.running import one_thread
from jointattn_mj.footage.config import PerceiveConfig, PerceiveOptions
from jointattn_mj.footage.reader import RATE
from jointattn_mj.footage.run import run_perceive
from jointattn_mj.footage.viewing import Viewing
from jointattn_mj.io.progress import Progress, count
from jointattn_mj.options import FLAT

LESS = "a shorter video"
SHOWN = 6
"""Entries of the list of what to check that are printed."""


def perceive(config: Annotated[PerceiveConfig, FLAT], options: Annotated[PerceiveOptions, FLAT]) -> None:
    """Show what the robot perceives in a video of a person at a table, and where it would look (section 6.3.2).

    A fixation is attention to a location in the image; no head turns. Faces need the extra footage (pip install
    'jointattn-mj[footage]').
    Leaves in --out: config.yaml, summary.json (with the mapping from the video to the robot's image), percepts.parquet
    (a row a frame), people.parquet (a row a face), events.csv, checks.csv, fixations.parquet, fixations.png, som.png,
    faces.parquet, overlay.mp4, checkpoint.bin; with --looks, looks.parquet (a row a look) and page/report.html. The
    command jointattn looks writes all events for ELAN, BORIS or Datavyu.
    """
    one_thread()
    shown = Progress("reading again up to the checkpoint" if options.resume else "opening the video", unit="s of video")

    def progress(viewing: Viewing) -> None:
        share = viewing.visible / viewing.frames
        words = f"face in {share[-1]:.0%}, {count(len(viewing.fixations.all), 'fixation')}"
        shown.doing("perceiving")
        shown.to(viewing.frames / RATE, words, _seconds(viewing))

    try:
        with shown:
            summary = run_perceive(config, options, progress)
    except KeyboardInterrupt:
        if (options.out / "summary.json").exists():
            left = f"results so far are in {options.out}; the same command with --resume goes on"
        elif (options.out / "checkpoint.bin").exists():
            left = f"the same command with --resume goes on from {options.out}"
        else:
            left = "nothing was written"
        print(f"jointattn: stopped; {left}", file=sys.stderr)
        raise
    shares = ", ".join(f"{name} {share:.0%}" for name, share in summary["detected"].items())
    print(f"{summary['watched_seconds']:.1f} s watched. Found: {shares}. {count(summary['fixations'], 'fixation')}.")
    for note in summary["notes"]:
        print(f"Note: {note}.")
    if summary["checks"]:
        shown_first = [
            f"{span['from_s']:.1f} to {span['to_s']:.1f} {span['what']}" for span in summary["check"][:SHOWN]
        ]
        more = f", and {summary['checks'] - SHOWN} more in checks.csv" if summary["checks"] > SHOWN else ""
        print(f"Check these seconds: {'; '.join(shown_first)}{more}.")
    if "looks" in summary:
        print(_of_looks(summary["looks"]))
        if summary["looks"].get("page"):
            print(f"Page: {options.out / summary['looks']['page']}")
        elif summary["looks"].get("why_no_page") and summary["looks"]["coded"]:
            print(f"No page: {summary['looks']['why_no_page']}.")
    print(f"In {summary['wall_seconds']:.1f} s. Results: {options.out}")


def _of_looks(looks: dict[str, Any]) -> str:
    """Where the person looked, and how far that can be trusted."""
    rested = ", ".join(f"{name} {count}" for name, count in looks["placements"].items())
    if looks["coded"]:
        shares = ", ".join(f"{name} {share:.0%}" for name, share in looks["shares"].items())
        words = f"Looks: {shares}. Sure of {looks['sure']:.0%}. Placements: {rested}."
    else:
        words = f"Looks were not coded: {looks['why_not']}. Placements: {rested}."
    if "check" in looks:
        words += f" Against your codings: {_of_check(looks['check'])}."
    return words


def _of_check(check: dict[str, Any]) -> str:
    """How a person's codings agree with these."""
    if not check["seconds"]:
        return "there is no time in which both say where somebody looks"
    if check["kappa"] is None:
        return f"kappa has no meaning, as both have one code alone, over {check['seconds']:.0f} s"
    interval = "" if check["low"] is None else f" [{check['low']:.2f}, {check['high']:.2f}]"
    return f"kappa {check['kappa']:.2f}{interval} over {check['seconds']:.0f} s"


def _seconds(viewing: Viewing) -> float | None:
    """The video's length in seconds, where it is known."""
    bounds = [bound for bound in (viewing.footage.declared_s, viewing.total / RATE) if bound is not None]
    least = min(bounds)
    return None if least == float("inf") else max(least, viewing.frames / RATE)
