"""Watches a video from beginning to end, and leaves what was perceived and attended to in a folder."""

import json
import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

from jointattn_mj.footage.config import PerceiveConfig, PerceiveOptions
from jointattn_mj.footage.frame_map import FrameMap
from jointattn_mj.footage.log import PerceptLog
from jointattn_mj.footage.overlay import HEIGHT, WIDTH, FootageOverlay
from jointattn_mj.footage.reader import RATE, Still
from jointattn_mj.footage.summary import summarise
from jointattn_mj.footage.viewing import Viewing
from jointattn_mj.recording.files import claimed, write_whole
from jointattn_mj.recording.interrupts import deferred
from jointattn_mj.recording.provenance import plain, write_config
from jointattn_mj.recording.reel import Reel, find_ffmpeg


def run_perceive(
    config: PerceiveConfig, options: PerceiveOptions, progress: Callable[[Viewing], object] = lambda viewing: None
) -> dict[str, Any]:
    """Watch a video and leave the results in ``options.out``; returns the summary.

    ``progress`` is called after every second of video. On Ctrl-C or SIGTERM the frame is finished, and what was watched
    so far leaves all its results before KeyboardInterrupt goes on.

    Raises:
        FootageError: The file is no video, or has no picture.
        OutputError: The folder holds another run, or cannot be written.
        VideoError: The overlay cannot be written.
    """
    if options.overlay:
        find_ffmpeg()
    viewing = Viewing(config)
    with claimed(options.out):
        return _run(viewing, config, options, progress)


def _run(
    viewing: Viewing, config: PerceiveConfig, options: PerceiveOptions, progress: Callable[[Viewing], object]
) -> dict[str, Any]:
    """Watch a video in a folder that is held for it."""
    out, started = options.out, time.perf_counter()
    viewing.measure_face()
    write_config(out / "config.yaml", config)
    log = PerceptLog(out / "percepts.parquet", viewing.names)
    stopped = False
    try:
        with deferred() as interrupts, ExitStack() as open_files:
            show = _overlay(viewing, options, log, open_files)
            for still in viewing.footage:
                mapped = viewing.see(still)
                log.add(viewing.watcher, still.number, still.fresh)
                show(still, mapped)
                if viewing.frames % RATE == 0:
                    progress(viewing)
                stopped = interrupts.requested
                if stopped or viewing.frames >= viewing.total:
                    break
    finally:
        log.close()
    summary = _leave_results(viewing, options, stopped, time.perf_counter() - started)
    if stopped:
        raise KeyboardInterrupt
    return summary


def _overlay(
    viewing: Viewing, options: PerceiveOptions, log: PerceptLog, open_files: ExitStack
) -> Callable[[Still, FrameMap], None]:
    """What shows a frame to the overlay video, if there is to be one."""
    if not options.overlay:
        return lambda still, mapped: None
    drawing = FootageOverlay(viewing.names, viewing.rgb, viewing.config.attention)
    reel = open_files.enter_context(Reel(options.out / "overlay.mp4", HEIGHT, WIDTH, RATE / options.overlay_every))

    def show(still: Still, mapped: FrameMap) -> None:
        if (viewing.frames - 1) % options.overlay_every == 0:
            reel.add(drawing.compose(still.picture, mapped, viewing.watcher, log))

    return show


def _leave_results(viewing: Viewing, options: PerceiveOptions, stopped: bool, wall_seconds: float) -> dict[str, Any]:
    from jointattn_mj.footage.figures import draw_fixations
    from jointattn_mj.recording.figures import draw_som
    from jointattn_mj.recording.parquet import write_parquet

    out = options.out
    write_parquet(out / "fixations.parquet", viewing.fixations.table(viewing.names))
    draw_fixations(
        out / "fixations.png",
        viewing.sample,
        viewing.fixations.all,
        out / "percepts.parquet",
        viewing.names,
        viewing.rgb,
    )
    error = None
    if viewing.album.seen:
        som = viewing.album.learn(viewing.config.som)
        error = round(som.quantisation_error(viewing.album.patterns), 4)
        draw_som(out / "som.png", som)
        write_parquet(out / "faces.parquet", viewing.album.table(som))
    summary = summarise(viewing, stopped, wall_seconds, error)
    write_whole(out / "summary.json", lambda path: path.write_text(json.dumps(plain(summary), indent=1) + "\n"))
    return summary
