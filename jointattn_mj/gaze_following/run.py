"""Runs a session: in memory, or in a folder with checkpoints, results, and resuming after a kill."""

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from jointattn_mj.gaze_following.result import SessionInMemory
from jointattn_mj.gaze_following.session import FRAMES_PER_MINUTE, FRAMES_PER_SECOND, SessionConfig, SessionRun
from jointattn_mj.gaze_following.shifts import write_shifts
from jointattn_mj.gaze_following.summary import SessionSummary
from jointattn_mj.gaze_following.tables import write_frames
from jointattn_mj.io import checkpoint
from jointattn_mj.io.files import claimed, free_name
from jointattn_mj.io.fitting import check_attributes, check_fits
from jointattn_mj.io.interrupts import deferred
from jointattn_mj.io.provenance import write_config
from jointattn_mj.io.rows import forget_log, log_folder, summary_of_ended
from jointattn_mj.io.space import check_free
from jointattn_mj.io.table import Table
from jointattn_mj.io.weights import write_weights
from jointattn_mj.options import Checked, Real, Whole

ShowFrame = Callable[[SessionRun], object]
"""Is called with the session in every frame, when the robot has perceived and decided and before anything moves."""
Watcher = Callable[[SessionRun], AbstractContextManager[ShowFrame]]
"""Makes, for a session that begins or is resumed, what is to be called in its frames; left when the session ends."""

BYTES_A_FRAME = 400
"""Disk space of a frame: as a row of the log, and in the Parquet file that the log becomes."""


@dataclass(frozen=True)
class SessionOptions(Checked):
    """Where a session leaves its results, and how much of it is shown."""

    out: Path
    """Folder for the results. It is made when missing, and refused when it holds another run."""
    resume: bool = False
    """Continue from the checkpoint in the folder, to the same final result."""
    video: bool = False
    """Also write a video of what the robot attends to and why. Slower: the scene is also rendered
    from outside."""
    video_every: Annotated[int, Whole("[1, 1e6]")] = 2
    """Write one frame of the video for so many of the session: 2 is 15 a second, 1 is 30 and takes twice the time."""
    checkpoint_minutes: Annotated[float, Real("(0, 1e6]")] = 2.0
    """Simulated minutes between checkpoints: at most so much is lost by a kill."""


def run_session(
    config: SessionConfig,
    options: SessionOptions,
    progress: Callable[[SessionRun], object] = lambda session: None,
    kind: type[SessionRun] = SessionRun,
    watchers: Sequence[Watcher] = (),
    prepare: Callable[[SessionRun], object] = lambda session: None,
) -> SessionSummary:
    """Run a session and leave its results in the folder ``options.out``.

    On Ctrl-C or SIGTERM the frame is finished and a checkpoint written before KeyboardInterrupt goes on.

    Args:
        config: What happens in the session.
        options: Where the results go.
        progress: Is called after every simulated second.
        kind: Class of the session. One with parts of your own has their classes in its own module, where a checkpoint
            finds them.
        watchers: What else is to see every frame, such as a log for a viewer.
        prepare: Is called once with the session, before it begins or goes on.

    Raises:
        ConfigError: The session's log would not fit onto the disk.
        OutputError: The folder holds another run, or cannot be written.
        CheckpointError: ``resume`` without a fitting checkpoint.
        GLError: Images are needed and cannot be rendered.
        VideoError: A video is asked for and cannot be written.
        NotFiniteError: What is learned or simulated has become NaN; the last checkpoint stays.
    """
    if options.video:
        watchers = (_film(options), *watchers)
    if not options.resume:
        needed = round(BYTES_A_FRAME * config.most_minutes * FRAMES_PER_MINUTE)
        check_free(options.out, needed, f"{config.most_minutes:,g} minutes", "fewer minutes")
    frozen, parts = options.out / "checkpoint.bin", (kind, progress, *watchers)
    with claimed(options.out, options.resume), checkpoint.gone_on_with(frozen, options.resume, *parts):
        return _run(config, options, progress, kind, watchers, prepare)


def run_in_memory(
    config: SessionConfig,
    progress: Callable[[SessionRun], object] = lambda session: None,
    kind: type[SessionRun] = SessionRun,
    watchers: Sequence[Watcher] = (),
) -> tuple[SessionSummary, SessionInMemory]:
    """Run a session without a folder: its summary, and its tables and weights.

    Arguments are those of :func:`run_session`.

    Raises:
        GLError: Images are needed and cannot be rendered.
        NotFiniteError: What is learned or simulated has become NaN.
    """
    started, session = time.perf_counter(), kind(config)
    try:
        session.begin()
        with _watched(session, watchers) as watch:
            while session.frame < session.total:
                session.advance(_frames_to(session.frame, FRAMES_PER_SECOND), watch)
                if session.frame % FRAMES_PER_SECOND == 0:
                    progress(session)
        session.check()
        frames, shifts, weights = Table(session.frames.table()), Table(session.shifts.table()), session.weights()
        return session.summary(time.perf_counter() - started), SessionInMemory(frames, shifts, weights)
    finally:
        session.close()


def _run(
    config: SessionConfig,
    options: SessionOptions,
    progress: Callable[[SessionRun], object],
    kind: type[SessionRun],
    watchers: Sequence[Watcher],
    prepare: Callable[[SessionRun], object],
) -> SessionSummary:
    """Run a session in a folder that is held for it."""
    out, path = options.out, options.out / "checkpoint.bin"
    started = time.perf_counter()
    if options.resume:
        spent, session = checkpoint.load(
            path, config, kind.__module__, kind=(float, kind), check=lambda loaded: _check_fits(loaded[1], kind(config))
        )
    else:
        spent, session = 0.0, kind(config)

    def save_checkpoint() -> None:
        session.check()
        checkpoint.save(path, (spent + time.perf_counter() - started, session), config, kind.__module__)

    try:
        if options.resume and (summary := summary_of_ended(out)) is not None:
            ended: SessionSummary = session.summary_of(summary)
            return ended
        if options.resume:
            session.go_on()
        prepare(session)
        if not options.resume:
            session.begin()
        session.attach(log_folder(out))
        if not options.resume:
            save_checkpoint()
        if not (out / "config.yaml").exists():
            write_config(out / "config.yaml", config)
        with deferred() as interrupts, _watched(session, watchers) as watch:
            pause = max(1, round(options.checkpoint_minutes * FRAMES_PER_MINUTE))
            while session.frame < session.total:
                session.advance(_frames_to(session.frame, FRAMES_PER_SECOND, pause), watch)
                if session.frame % pause == 0 or interrupts.requested:
                    save_checkpoint()
                if interrupts.requested:
                    raise KeyboardInterrupt
                if session.frame % FRAMES_PER_SECOND == 0:
                    progress(session)
        save_checkpoint()
        return _leave_results(session, out, spent + time.perf_counter() - started)
    finally:
        session.close()


def _frames_to(frame: int, *periods: int) -> int:
    """Frames from number ``frame`` to the next multiple of one of ``periods``."""
    return min(period - frame % period for period in periods)


def _check_fits(session: SessionRun, new: SessionRun) -> None:
    """Refuse a session from a checkpoint whose tables, or what it has learned, are not built as in a new one.

    Its length follows from the config, too, unless it has ended early or is about to.

    Raises:
        ValueError: They are not.
    """
    try:
        check_attributes(session, new, "the session")
        check_attributes(session.robot, new.robot, "the robot")
        for name in ("names", "config", "total", "frames", "shifts"):
            check_fits(getattr(session, name), getattr(new, name), name)
        for name in ("som", "mean_face", "learner"):
            check_fits(getattr(session.robot, name), getattr(new.robot, name), name)
        if type(session._observation) is not type(new._observation):
            raise ValueError("its robot and that of the config differ in whether they know how late the camera is")
        if session.frames.index != new.frames.index:
            raise ValueError("the table of frames has other columns")
        if session.frame != session.frames.frames:
            raise ValueError(f"{session.frame} frames are done, and the table has {session.frames.frames}")
        if session.total != new.total and session.total > session.frame + 1:
            raise ValueError(f"it has {session.total} frames in all, and under this config {new.total}")
    finally:
        new.close()


def _film(options: SessionOptions) -> Watcher:
    """A video in the session's folder.

    Raises:
        VideoError: There is no ffmpeg program.
    """
    from jointattn_mj.gaze_following.film.video import Film  # slow to import, and most sessions need no video
    from jointattn_mj.video.reel import find_ffmpeg

    find_ffmpeg()
    return lambda session: Film(free_name(options.out / "video.mp4"), session, options.video_every)


@contextmanager
def _watched(session: SessionRun, watchers: Sequence[Watcher]) -> Iterator[ShowFrame | None]:
    """What calls all watchers in a frame; None without watchers, or when no frame is left."""
    with ExitStack() as stack:
        shown = [stack.enter_context(new(session)) for new in watchers if session.frame < session.total]

        def watch(session: SessionRun) -> None:
            for show in shown:
                show(session)

        yield watch if shown else None


def _leave_results(session: SessionRun, out: Path, wall_seconds: float) -> SessionSummary:
    summary: SessionSummary = session.summary(wall_seconds)
    write_frames(out / "frames.parquet", session.frames)
    write_shifts(out / "gaze_shifts.parquet", session.shifts)
    write_weights(out / "weights.npz", session.weights())
    session.draw(out)
    summary.write(out / "summary.json")
    forget_log(out)
    return summary
