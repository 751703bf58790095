"""``jointattn session --world video`` and ``--world camera``: a session before a recorded or present person."""

import sys
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from jointattn_mj.cli.running import going_on_from, one_thread
from jointattn_mj.cli.session import RECENT, PresetOptions
from jointattn_mj.errors import ConfigError
from jointattn_mj.footage.reader import Footage
from jointattn_mj.footage.sessions.config import CameraSessionConfig, FootageSessionConfig, VideoSessionConfig
from jointattn_mj.footage.sessions.run import run_footage_session
from jointattn_mj.footage.sessions.session import FootageSessionRun
from jointattn_mj.footage.sessions.summary import FootageSessionSummary
from jointattn_mj.gaze_following.session import FRAMES_PER_MINUTE
from jointattn_mj.gaze_following.summary import LATE_MINUTES
from jointattn_mj.io.progress import Progress, count
from jointattn_mj.options import FLAT, Checked, Real, Whole

THESIS = PresetOptions()
Port = Annotated[int, Whole("[1, 65535]")]


@dataclass(frozen=True)
class VideoSessionOptions(Checked):
    """Where a session at a recorded table leaves its results, and how much of it is shown."""

    out: Path
    """Folder for the results. It is made when missing, and refused when it holds another run."""
    resume: bool = False
    """Continue from the checkpoint in the folder, to the same final result."""
    checkpoint_minutes: Annotated[float, Real("(0, 1e6]")] = 2.0
    """Minutes between checkpoints: at most so much is lost by a kill."""
    live: bool = False
    """Show what the robot sees, attends to and knows on a page of this machine, whose address is printed."""
    port: Port = 8080
    """First port of that page to try; the next free one is taken."""


@dataclass(frozen=True)
class CameraSessionOptions(Checked):
    """What a session with a person leaves, and how it is shown."""

    out: Path | None = None
    """Folder for the results: tables, weights, and the map of faces, which shows the person's face. No images of the
    camera are stored. If not given, nothing is stored at all."""
    resume: bool = False
    """Continue from the checkpoint in the folder, with what was learned."""
    checkpoint_minutes: Annotated[float, Real("(0, 1e6]")] = 2.0
    """Minutes between checkpoints: at most so much is lost by a kill."""
    live: bool = True
    """Show what the robot sees, attends to and knows on a page of this machine, whose address is printed."""
    port: Port = 8080
    """First port of that page to try; the next free one is taken."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.resume and self.out is None:
            raise ConfigError("--resume needs the folder of the session that is to go on; name it with --out")


NOTHING_STORED = CameraSessionOptions()


def video(
    config: Annotated[VideoSessionConfig, FLAT],
    options: Annotated[VideoSessionOptions, FLAT],
    preset: Annotated[PresetOptions, FLAT] = THESIS,
) -> None:
    """Let the robot of chapter 6 learn at a recorded table: a video of a person takes the caregiver's place.

    The robot's head turns by taking its image from another part of the video. Faces need the extra footage (pip install
    'jointattn-mj[footage]'). Success is counted where --coding or --looks-at says where the person looks.
    Leaves in --out: config.yaml, summary.json, gaze_shifts.parquet (a row a gaze shift), frames.parquet (a row a
    frame), som.png, success.png where success is known, weights.npz, checkpoint.bin.
    """
    one_thread()
    length = Footage(config.video_file, config.fps).declared_s
    wanted = None if length is None else length / 60 - config.robot.familiarise.minutes * (config.start_from is None)
    minutes = min((limit for limit in (config.minutes, wanted) if limit is not None), default=None)
    with going_on_from(options.out, "the session"):
        summary = _run(config, options, minutes)
    _print(summary, options.out)


def camera(
    config: Annotated[CameraSessionConfig, FLAT],
    options: Annotated[CameraSessionOptions, FLAT] = NOTHING_STORED,
    preset: Annotated[PresetOptions, FLAT] = THESIS,
) -> None:
    """Let the robot of chapter 6 learn from a person before a camera, live.

    A page on this machine shows what the robot sees, attends to and knows, and whether it followed. Nothing leaves the
    machine; nothing is stored without --out. Faces need the extra footage (pip install 'jointattn-mj[footage]').
    Ctrl-C stops; with --out, --resume goes on. Leaves in --out: what --world video leaves.
    """
    one_thread()
    out = options.out
    with nullcontext() if out is None else going_on_from(out, "the session"):
        summary = _run(config, options, config.minutes)
    _print(summary, out)


def _run(
    config: FootageSessionConfig, options: VideoSessionOptions | CameraSessionOptions, minutes: float | None
) -> FootageSessionSummary:
    """Run a session with progress, and with the live view if it is asked for."""
    doing = "reading again up to the checkpoint" if options.resume else "learning the person's face"
    bar = Progress(doing, minutes, "min", digits=1)
    recent, counted, of_all = deque[bool | None](maxlen=RECENT), 0, 0

    def progress(session: FootageSessionRun) -> None:
        nonlocal counted, of_all
        new = [row.success for row in session.shifts[of_all:] if row.face_to_object]
        recent.extend(new)
        counted, of_all = counted + len(new), len(session.shifts)
        judged = [bool(success) for success in recent if success is not None]
        rate = f", success {sum(judged) / len(judged):.0%} of the last {len(judged)}" if judged else ""
        bar.doing("session")
        bar.to(session.frame / FRAMES_PER_MINUTE, f"{count(counted, 'gaze shift')}{rate}")

    with _live(options) as prepare, bar:
        return run_footage_session(config, options.out, options.resume, options.checkpoint_minutes, progress, prepare)


@contextmanager
def _live(options: VideoSessionOptions | CameraSessionOptions) -> Iterator[Any]:
    """What takes hold of a session for the live view; nothing without it."""
    if not options.live:
        yield lambda session: None
        return
    from jointattn_mj.viewing.live import LiveView

    with LiveView(options.port) as view:

        def take_hold(session: FootageSessionRun) -> None:
            session.wide.image()  # without a camera there is nothing to see
            print(f"{view.address}  (this machine alone; Ctrl-C ends the session)", file=sys.stderr, flush=True)
            view.attach(session)

        yield take_hold


def _print(summary: FootageSessionSummary, out: Path | None) -> None:
    shifts = f"{count(summary.gaze_shifts, 'gaze shift')} from the face to an object"
    learner = f"{summary.gaze_shifts_by_learner} of them by what was learned"
    if summary.successes is None:
        followed = "success is not known"
    else:
        late = summary.late_success_rate
        last = f" over the last {LATE_MINUTES:g} minutes" if summary.minutes > LATE_MINUTES else ""
        followed = (
            f"{summary.successes} of {summary.gaze_shifts_judged} to where the person looked "
            f"({'-' if late is None else format(late, '.0%')}{last})"
        )
    print(f"{summary.minutes:.1f} minutes: {shifts}, {learner}; {followed}.")
    if summary.camera is not None and summary.camera.latency_median_ms is not None:
        times = summary.camera
        print(
            f"From image to decision {times.latency_median_ms:.0f} ms (95% below "
            f"{times.latency_percentile_95_ms:.0f} ms); {times.images_lost} of {times.images} images were lost, and "
            f"{times.frames_lost} frames."
        )
    for note in summary.notes:
        print(f"Note: {note}.")
    print(f"In {summary.wall_seconds:.0f} s. {'Nothing was stored' if out is None else f'Results: {out}'}.")
