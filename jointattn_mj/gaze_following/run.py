"""Runs a session in a folder: progress, checkpoints, results, and going on after a kill."""

import json
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from jointattn_mj.errors import ConfigError, OutputError
from jointattn_mj.gaze_following import figures
from jointattn_mj.gaze_following.session import FRAMES_PER_MINUTE, FRAMES_PER_SECOND, SessionConfig, SessionRun
from jointattn_mj.gaze_following.shifts import write_shifts
from jointattn_mj.gaze_following.tables import write_frames
from jointattn_mj.io import checkpoint
from jointattn_mj.io.files import claimed, free_name, write_whole
from jointattn_mj.io.interrupts import deferred
from jointattn_mj.io.provenance import write_config
from jointattn_mj.io.rows import forget_log, log_folder, summary_of_ended
from jointattn_mj.io.space import check_free
from jointattn_mj.io.weights import write_weights
from jointattn_mj.options import Checked, Real, Whole

BYTES_A_FRAME = 400
"""On the disk, first as rows, then as Parquet as well."""


@dataclass(frozen=True)
class SessionOptions(Checked):
    """Where a session leaves its results, and how much of it is shown."""

    out: Path
    """Folder for the results; made when missing, refused when it holds another run."""
    resume: bool = False
    """Go on from the checkpoint in the folder, to the same final result."""
    video: bool = False
    """Also leave a video that shows what the robot attends to and why (slower: every frame is rendered twice)."""
    video_every: Annotated[int, Whole("[1, 1e6]")] = 1
    """Frames of the session for one of the video: 1 is 30 a second, 2 is 15 and takes half the time."""
    rerun: Path | None = None
    """Also write a log for Rerun's viewer, FILE.rrd; needs the extra ``rerun``."""
    checkpoint_minutes: Annotated[float, Real("(0, 1e6]")] = 2.0
    """Simulated minutes between checkpoints: at most so much is lost by a kill."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.rerun is not None and self.rerun.suffix != ".rrd":
            raise ConfigError(f"rerun must be a file that ends in .rrd, as its viewer expects; got {self.rerun}")


def run_session(
    config: SessionConfig,
    options: SessionOptions,
    progress: Callable[[SessionRun], None] = lambda session: None,
    kind: type[SessionRun] = SessionRun,
) -> dict[str, Any]:
    """Run a session and leave its results in ``options.out``; returns the summary.

    ``progress`` is called after every simulated second; ``kind`` is for sessions with parts of your own, whose classes
    a checkpoint may then hold if they are in the same module. On Ctrl-C or SIGTERM the frame is finished and a
    checkpoint written before KeyboardInterrupt goes on.

    Raises:
        ConfigError: The session's log would not fit onto the disk.
        OutputError: The folder holds another run, or cannot be written.
        CheckpointError: ``resume`` without a fitting checkpoint.
        GLError: Images are needed and cannot be rendered.
        VideoError: A video is asked for and cannot be written.
        ExtraError: A log is asked for, and the package that writes it is missing.
        NotFiniteError: What is learned or simulated has become NaN; the last checkpoint stays.
    """
    if options.video:
        _check_ffmpeg()
    if options.rerun is not None:
        _check_rerun(options.rerun, options.resume)
    if not options.resume:
        needed = round(BYTES_A_FRAME * config.minutes * FRAMES_PER_MINUTE)
        check_free(options.out, needed, f"--minutes {config.minutes:g}", "fewer --minutes")
    with claimed(options.out, options.resume):
        return _run(config, options, progress, kind)


def _run(
    config: SessionConfig, options: SessionOptions, progress: Callable[[SessionRun], None], kind: type[SessionRun]
) -> dict[str, Any]:
    """Run a session in a folder that is held for it."""
    out, frozen = options.out, options.out / "checkpoint.bin"
    started = time.perf_counter()
    if options.resume:
        spent, session = checkpoint.load(frozen, config, kind.__module__, kind=(float, kind))
    else:
        spent, session = 0.0, kind(config)

    def freeze() -> None:
        session.check()
        checkpoint.save(frozen, (spent + time.perf_counter() - started, session), config, kind.__module__)

    try:
        if options.resume and (summary := summary_of_ended(out)) is not None:
            return summary
        if not options.resume:
            session.begin()
        session.attach(log_folder(out))
        if not options.resume:
            freeze()
        if not (out / "config.yaml").exists():
            write_config(out / "config.yaml", config)
        with deferred() as interrupts, _watchers(session, options) as watch:
            pause = max(1, round(options.checkpoint_minutes * FRAMES_PER_MINUTE))
            while session.frame < session.total:
                session.step(watch)
                if session.frame % pause == 0 or interrupts.requested:
                    freeze()
                if interrupts.requested:
                    raise KeyboardInterrupt
                if session.frame % FRAMES_PER_SECOND == 0:
                    progress(session)
        freeze()
        return _leave_results(session, out, spent + time.perf_counter() - started)
    finally:
        session.close()


def _check_ffmpeg() -> None:
    from jointattn_mj.video.reel import find_ffmpeg  # imports ffmpeg's wrapper, which most sessions do not need

    find_ffmpeg()


def _check_rerun(path: Path, resume: bool) -> None:
    from jointattn_mj.io.extras import extra

    extra("rerun", "rerun")
    if path.exists() and not resume:
        raise OutputError(f"{path} is already there; choose another --rerun")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"cannot make the folder {path.parent}: {error.strerror}; choose another --rerun") from error


@contextmanager
def _watchers(session: SessionRun, options: SessionOptions) -> Iterator[Callable[[SessionRun], None] | None]:
    """What is shown every frame: a film, a log, or nothing."""
    with ExitStack() as stack:
        watchers: list[Callable[[SessionRun], None]] = []
        if options.video and session.frame < session.total:
            from jointattn_mj.gaze_following.film.video import Film

            film = Film(free_name(options.out / "video.mp4"), session, options.video_every)
            watchers.append(stack.enter_context(film))
        if options.rerun is not None and session.frame < session.total:
            from jointattn_mj.adapters.rerun import SessionLog

            watchers.append(stack.enter_context(SessionLog(free_name(options.rerun), session)))

        def watch(session: SessionRun) -> None:
            for watcher in watchers:
                watcher(session)

        yield watch if watchers else None


def _leave_results(session: SessionRun, out: Path, wall_seconds: float) -> dict[str, Any]:
    summary = session.summary(wall_seconds)
    write_frames(out / "frames.parquet", session.frames)
    write_shifts(out / "gaze_shifts.parquet", session.shifts)
    write_weights(out / "weights.npz", session.weights())
    figures.draw_success(out / "success.png", session.shifts, session.config.minutes)
    figures.draw_som(out / "som.png", session.robot.som)
    write_whole(out / "summary.json", lambda path: path.write_text(json.dumps(summary, indent=1) + "\n"))
    forget_log(out)
    return summary
