"""Runs a session before a person: in a folder with checkpoints, as sessions of chapter 6 do, or leaving no trace."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from jointattn_mj.errors import ConfigError
from jointattn_mj.footage.sessions.config import CameraSessionConfig, FootageSessionConfig
from jointattn_mj.footage.sessions.session import FootageSessionRun, VideoSessionRun
from jointattn_mj.footage.sessions.summary import FootageSessionSummary
from jointattn_mj.gaze_following.run import SessionOptions, run_session
from jointattn_mj.gaze_following.session import FRAMES_PER_SECOND
from jointattn_mj.io.interrupts import deferred

Hook = Callable[[FootageSessionRun], object]


def kind_of(config: FootageSessionConfig) -> type[FootageSessionRun]:
    """The class of the sessions of a config."""
    if isinstance(config, CameraSessionConfig):
        from jointattn_mj.footage.sessions.camera import CameraSessionRun

        return CameraSessionRun
    return VideoSessionRun


def run_footage_session(
    config: FootageSessionConfig,
    out: Path | None,
    resume: bool = False,
    checkpoint_minutes: float = 2.0,
    progress: Hook = lambda session: None,
    prepare: Hook = lambda session: None,
) -> FootageSessionSummary:
    """Run a session before a person.

    On Ctrl-C a session with a folder leaves a checkpoint, and KeyboardInterrupt goes on; one without ends.

    Args:
        config: What happens in it.
        out: Folder for the results; None stores nothing.
        resume: Continue from the checkpoint in ``out``.
        checkpoint_minutes: Minutes between checkpoints.
        progress: Is called after every second of the session.
        prepare: Is called once with the session, before it begins or goes on: a live view takes hold of it there.

    Returns:
        The summary.

    Raises:
        FootageError: Video or camera cannot be used, or shows no face.
        ConfigError: ``resume`` without a folder, or a coding of other objects.
        ExtraError: The network that finds faces is not installed.
        OutputError: The folder holds another run, or cannot be written.
        CheckpointError: ``resume`` without a fitting checkpoint.
        SeriesError: The coding cannot be read.
    """
    if out is not None:
        options = SessionOptions(out=out, resume=resume, checkpoint_minutes=checkpoint_minutes)
        run: Any = run_session  # its types are those of sessions in the rendered world
        summary: FootageSessionSummary = run(config, options, progress, kind_of(config), prepare=prepare)
        return summary
    if resume:
        raise ConfigError("resume needs the folder out of the session that is to go on")
    return _run_without_trace(kind_of(config)(config), progress, prepare)


def _run_without_trace(session: FootageSessionRun, progress: Hook, prepare: Hook) -> FootageSessionSummary:
    started = time.perf_counter()
    try:
        prepare(session)
        session.begin()
        with deferred() as interrupts:
            while session.frame < session.total and not interrupts.requested:
                session.step()
                if session.frame % FRAMES_PER_SECOND == 0:
                    progress(session)
        session.check()
        summary: FootageSessionSummary = session.summary(time.perf_counter() - started)
        return summary
    finally:
        session.close()
