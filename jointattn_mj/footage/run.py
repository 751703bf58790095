"""Watches a video: frame by frame for Python, or to its end with results, checkpoints and an overlay in a folder."""

import json
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path
from typing import Any

from jointattn_mj.errors import CheckpointError, ConfigError, OutputError
from jointattn_mj.footage.colours import candidate_names
from jointattn_mj.footage.config import PerceiveConfig, PerceiveOptions
from jointattn_mj.footage.frames import PerceivedFrame, frame_now
from jointattn_mj.footage.looks.check import Codings
from jointattn_mj.footage.looks.coding import AWAY, PARTNER
from jointattn_mj.footage.looks.log import LooksLog
from jointattn_mj.footage.looks.run import leave_looks
from jointattn_mj.footage.reader import RATE, Still
from jointattn_mj.footage.records import CHECKPOINT, ViewingCheckpoint, ViewingRecords
from jointattn_mj.footage.spans import write_spans
from jointattn_mj.footage.summary import OLD_KEYS, summarise
from jointattn_mj.footage.viewing import Viewing
from jointattn_mj.io import checkpoint
from jointattn_mj.io.files import claimed, write_whole
from jointattn_mj.io.interrupts import Interrupts, deferred
from jointattn_mj.io.provenance import plain, write_config
from jointattn_mj.io.results import without_nan
from jointattn_mj.io.rows import forget_log
from jointattn_mj.options import warn_renamed
from jointattn_mj.video.reel import find_ffmpeg


def percepts(config: PerceiveConfig) -> Iterator[PerceivedFrame]:
    """What is perceived in a video, frame after frame; the video is read as far as is asked for.

    Raises:
        FootageError: The file is no video, or has no image.
    """
    viewing = Viewing(config)
    viewing.prepare()

    def frames() -> Iterator[PerceivedFrame]:
        for still in viewing.footage:
            viewing.see(still)
            yield frame_now(viewing, still)
            if viewing.frames >= viewing.total:
                return

    return frames()


def run_perceive(
    config: PerceiveConfig, options: PerceiveOptions, progress: Callable[[Viewing], object] = lambda viewing: None
) -> dict[str, Any]:
    """Watch a video and leave the results in the folder ``options.out``.

    On Ctrl-C or SIGTERM the frame is finished. What was watched so far leaves a checkpoint and all its results, and
    KeyboardInterrupt goes on.

    Args:
        config: What is perceived and attended to.
        options: Where the results go.
        progress: Is called after every second of video.

    Returns:
        The summary.

    Raises:
        FootageError: The file is no video, or has no image.
        OutputError: The folder holds another run, or cannot be written.
        CheckpointError: ``resume`` without a fitting checkpoint.
        VideoError: The overlay cannot be written.
        ConfigError: ``check`` or ``labels`` without ``looks``, or ``blur_faces`` with a detector that finds one face.
        SeriesError: The codings cannot be read, or have codes of other things.
    """
    if options.blur_faces and config.detector != "yunet":
        raise ConfigError(f"blur_faces: only the detector yunet finds all faces; got {config.detector}")
    if options.overlay:
        find_ffmpeg()
    codings = _codings(config, options.check, "check")
    known = _codings(config, config.labels, "labels")
    viewing = Viewing(config)
    frozen = options.out / CHECKPOINT
    with claimed(options.out, options.resume), checkpoint.gone_on_with(frozen, options.resume, progress):
        return _run(viewing, options, codings, known, progress)


def _run(
    viewing: Viewing,
    options: PerceiveOptions,
    codings: Codings | None,
    known: Codings | None,
    progress: Callable[[Viewing], object],
) -> dict[str, Any]:
    """Watch a video in a folder that is held for it."""
    out, config = options.out, viewing.config
    kept = ViewingCheckpoint.load(out, config) if options.resume else None
    if kept is not None and kept.finished:
        return _summary_of_finished(out, codings)
    if kept is None:
        viewing.prepare()
    records = ViewingRecords(viewing, options, kept)
    if kept is None:
        records.save_checkpoint()
    if not (out / "config.yaml").exists():
        write_config(out / "config.yaml", config)
    pause = max(1, round(options.checkpoint_minutes * 60 * RATE))
    with deferred() as interrupts, records:
        for still in _new_frames(viewing, interrupts):
            records.add(still, viewing.see(still))
            if viewing.frames % RATE == 0:
                progress(viewing)
            if viewing.frames % pause == 0:
                records.save_checkpoint()
        records.save_checkpoint()
    records.write()
    summary = _leave_results(
        viewing, options, records.looks, codings, known, interrupts.requested, records.wall_seconds
    )
    if interrupts.requested:
        raise KeyboardInterrupt
    records.save_checkpoint(finished=True)
    forget_log(out)
    return summary


def _new_frames(viewing: Viewing, interrupts: Interrupts) -> Iterator[Still]:
    """The frames that were not watched yet, until there are enough or somebody stops; at least one of a new viewing.

    A resumed viewing reads the video from its beginning, since only that gives the same images.
    """
    stills = iter(viewing.footage)
    for _ in islice(stills, viewing.frames):
        if interrupts.requested:
            raise KeyboardInterrupt
    while viewing.frames < viewing.total and not (interrupts.requested and viewing.frames):
        still = next(stills, None)
        if still is None:
            return
        yield still


def _codings(config: PerceiveConfig, path: Path | None, option: str) -> Codings | None:
    """What a person has coded, read before the video is.

    Args:
        config: Must have ``looks``.
        path: The file that the option names, if it does.
        option: Its name.
    """
    if path is None:
        return None
    if not config.looks:
        raise ConfigError(f"{option} {path} is for coded looks: looks must be set, too")
    codings = Codings.read(path)
    names = (*candidate_names(config.objects, config.areas_each), PARTNER, AWAY)
    codings.check_codes(names, all_of_them=option == "labels")
    return codings


def compared(codings: Codings, out: Path) -> dict[str, Any]:
    """How a person's codings agree with those in a folder, as JSON knows it: None in place of NaN."""
    agreed: dict[str, Any] = without_nan(codings.compare(Codings.read(out / "events.csv")))
    return agreed


def _summary_of_finished(out: Path, codings: Codings | None) -> dict[str, Any]:
    try:
        summary = read_summary(out)
        if codings is not None:
            summary["looks"]["check"] = compared(codings, out)
            _write_summary(out, summary)
        return summary
    except OutputError as error:
        raise CheckpointError(f"the viewing in {out} is finished, but its summary.json is gone or damaged") from error


def read_summary(out: Path) -> dict[str, Any]:
    """The summary of a viewing in ``out``.

    Raises:
        OutputError: There is none, or it cannot be read.
    """
    try:
        summary: dict[str, Any] = json.loads((out / "summary.json").read_text())
        for old, name in OLD_KEYS.items():
            if old in summary:
                warn_renamed(f"{old} in {out / 'summary.json'}", name)
                summary[name] = summary.pop(old)
        return summary
    except (OSError, ValueError, AttributeError) as error:
        raise OutputError(f"{out / 'summary.json'} is missing or damaged; give the folder of a video") from error


def _leave_results(
    viewing: Viewing,
    options: PerceiveOptions,
    looks: LooksLog,
    codings: Codings | None,
    known: Codings | None,
    stopped: bool,
    wall_seconds: float,
) -> dict[str, Any]:
    from jointattn_mj.footage.blurring import blurred
    from jointattn_mj.footage.figures import draw_fixations
    from jointattn_mj.gaze_following.figures import draw_som
    from jointattn_mj.io.parquet import write_parquet

    out, start_s = options.out, viewing.footage.start_s
    write_parquet(out / "fixations.parquet", viewing.fixations.table(viewing.names, start_s))
    write_spans(out / "checks.csv", viewing.checks(), start_s)
    draw_fixations(
        out / "fixations.png",
        blurred(viewing.sample, viewing.sample_faces) if options.blur_faces else viewing.sample,
        viewing.fixations.all,
        out.absolute() / "percepts.parquet",
        viewing.names,
        viewing.rgb,
        start_s,
    )
    error, som = None, None
    if viewing.album.offered:
        som = viewing.album.learn(viewing.config.som)
        error = round(som.quantisation_error(viewing.album.patterns), 4)
        if not options.blur_faces:
            draw_som(out / "som.png", som)
        write_parquet(out / "faces.parquet", viewing.album.table(som, start_s))
    events, summary = viewing.events(), summarise(viewing, stopped, wall_seconds, error)
    if viewing.config.looks:
        summary["looks"], spans = leave_looks(out, looks, viewing, som, known)
        events += spans
    write_spans(out / "events.csv", events, start_s)
    if viewing.config.looks and options.page:
        from jointattn_mj.footage.looks.page import write_looks_page  # slow to import

        summary["looks"] |= write_looks_page(out, summary["looks"]["why_not"])
    if codings is not None:
        summary["looks"]["check"] = compared(codings, out)
    _write_summary(out, summary)
    return summary


def _write_summary(out: Path, summary: dict[str, Any]) -> None:
    write_whole(out / "summary.json", lambda path: path.write_text(json.dumps(plain(summary), indent=1) + "\n"))
