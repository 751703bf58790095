"""A session from Python: the same options and results as ``jointattn session``."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from os import PathLike
from pathlib import Path
from typing import Any, Literal

from jointattn_mj.api.session_result import SessionResult
from jointattn_mj.errors import ConfigError, OutputError
from jointattn_mj.gaze_following.agent import RobotConfig
from jointattn_mj.gaze_following.presets import PRESETS, Preset
from jointattn_mj.gaze_following.result import SessionFolder
from jointattn_mj.gaze_following.run import SessionOptions, Watcher, run_in_memory, run_session
from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.gaze_following.summary import SessionSummary
from jointattn_mj.gaze_following.varied_session import VariedSessionConfig, VariedSessionRun
from jointattn_mj.io.extras import extra
from jointattn_mj.io.files import free_name, make_room
from jointattn_mj.options import as_arguments, changed, check_argument, check_called, path_of, shown, with_new_choice
from jointattn_mj.perception.pixels import PixelConfig
from jointattn_mj.perception.state import StateConfig
from jointattn_mj.scene.model import Quality
from jointattn_mj.scene.world import WorldConfig


@dataclass(frozen=True)
class LoggedSessionOptions(SessionOptions):
    """Where a session leaves its results, and how much of it is shown."""

    rerun: Path | None = None
    """Also write a log for Rerun's viewer, FILE.rrd. Needs the extra ``rerun``."""

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_suffix(self.rerun)


@dataclass(frozen=True, init=False)
class Session(VariedSessionConfig):
    """A session of chapter 6: the robot learns to look where the caregiver looks.

    The options are those of ``jointattn session`` under the same names. A group of them, such as ``robot``, is a config
    or a mapping of what differs: ``robot={"gaze": {"gate": "open"}}``.

    Args:
        minutes: Simulated minutes.
        seed: Seed of all random draws: the same seed gives the same result.
        perception: ``"pixels"`` (rendered images) or ``"state"`` (the simulator's state with measured errors, faster).
        success: Whose target counts as success: at ``"launch"`` or ``"landing"`` of the gaze shift, or ``"either"``.
        start_from: weights.npz of an earlier session, whose robot goes on learning.
        world: ``WorldConfig``: scene, caregiver, and the robot's body.
        robot: ``RobotConfig``: attention, learning and gaze control.
        pixels: ``PixelConfig``: how images are perceived.
        state: ``StateConfig``: errors of perception with ``perception="state"``.
        variation: What of the world varies with the seed, such as ``"lights+people"``.
        knows_delay: Whether the robot knows how late its camera is, where that varies.
        preset: ``"thesis"``: the robot of chapter 6 as it is written. ``"cross_situational"``: one that learns which of
            the objects in view goes with a face. A mapping for ``robot`` comes on top; a config replaces it.
        caregiver: Who the caregiver is, such as ``"noa"``; part of ``world``.
        quality: ``"fast"`` or ``"high"``, of rendered images; part of ``world``.
        motion_cues: Whether attention uses motion saliency; part of ``robot``.

    Raises:
        ConfigError: A value that is not allowed; the message says which are.

    Examples:
        >>> from jointattn_mj import Session
        >>> result = Session(minutes=2, perception="state", seed=0).run()
        >>> result.summary.frames
        3600
        >>> bool(result.shifts["landing_s"].max() < 120)
        True
    """

    def __init__(
        self,
        minutes: float = VariedSessionConfig.minutes,
        seed: int = 0,
        perception: Literal["pixels", "state"] = "pixels",
        success: Literal["either", "launch", "landing"] = "either",
        start_from: str | PathLike[str] | None = None,
        world: WorldConfig | Mapping[str, Any] | None = None,
        robot: RobotConfig | Mapping[str, Any] | None = None,
        pixels: PixelConfig | Mapping[str, Any] | None = None,
        state: StateConfig | Mapping[str, Any] | None = None,
        variation: str = "none",
        knows_delay: bool = True,
        *,
        preset: Preset = "thesis",
        caregiver: str | None = None,
        quality: Quality | None = None,
        motion_cues: bool | None = None,
    ):
        check_argument("preset", preset, Preset)
        plain = {
            "minutes": minutes, "seed": seed, "perception": with_new_choice(Session, "perception", perception),
            "success": success, "start_from": start_from, "variation": variation,
            "knows_delay": knows_delay,
        }  # fmt: skip
        parts = {
            "world": world, "robot": robot, "pixels": pixels, "state": state, "caregiver": caregiver,
            "quality": quality, "motion_cues": motion_cues,
        }  # fmt: skip
        given = plain | {name: value for name, value in parts.items() if value is not None}
        config = changed(VariedSessionConfig(robot=PRESETS[preset]), given)
        for field in fields(config):
            object.__setattr__(self, field.name, getattr(config, field.name))

    @property
    def config(self) -> VariedSessionConfig:
        """What decides the session, without the way to run it."""
        names = [field.name for field in fields(VariedSessionConfig)]
        return VariedSessionConfig(**{name: getattr(self, name) for name in names})

    def replace(self, **changes: Any) -> "Session":
        """The same with other values of some options; all others stay.

        Args:
            changes: Options by name, but for preset, from which those of ``robot`` follow.

        Returns:
            Another session; this one stays as it is.

        Raises:
            ConfigError: No such option, or a value that is not allowed.

        Examples:
            >>> from jointattn_mj import Session
            >>> Session(minutes=2, perception="state").replace(seed=2)
            Session(minutes=2, seed=2, perception='state')
        """
        if "preset" in changes:
            raise ConfigError("the options of robot follow from preset; make another Session with it")
        config = changed(self.config, changes)
        return Session(**{field.name: getattr(config, field.name) for field in fields(config)})

    def run(
        self,
        out: str | PathLike[str] | None = None,
        *,
        resume: bool = False,
        video: bool = False,
        video_every: int = 2,
        rerun: str | PathLike[str] | None = None,
        checkpoint_minutes: float = 2.0,
        progress: Callable[[SessionRun], object] = lambda session: None,
        kind: type[SessionRun] = VariedSessionRun,
    ) -> SessionResult:
        """Run the session, in a folder or in memory.

        Args:
            out: Folder for the results. Without one the session runs in memory and leaves no files.
            resume: Continue from the checkpoint in ``out``, to the same final result.
            video: Also write a video into ``out`` (slow).
            video_every: Write one frame of the video for so many of the session.
            rerun: Also write a log for Rerun's viewer, a file that ends in .rrd.
            checkpoint_minutes: Simulated minutes between checkpoints in ``out``.
            progress: Is called with the session after every simulated second.
            kind: Class of the session; a subclass of ``VariedSessionRun`` or ``SessionRun`` brings parts of your own.

        Returns:
            The result. Its tables are read from ``out`` when they are first asked for.

        Raises:
            ConfigError: Options that do not go together.
            OutputError: The folder holds another run, or cannot be written.
            CheckpointError: ``resume`` without a fitting checkpoint.
            GLError: Images are needed and cannot be rendered here.
            VideoError: A video is asked for and cannot be written.
            ExtraError: ``rerun`` is asked for and not installed.
            NotFiniteError: What is learned or simulated has become NaN.

        Examples:
            >>> from jointattn_mj import Session
            >>> result = Session(minutes=0.5, perception="state").run(out="out/in_a_folder")
            >>> sorted(path.name for path in result.folder.glob("*.parquet"))
            ['frames.parquet', 'gaze_shifts.parquet']
        """
        check_called("progress", progress)
        if not (isinstance(kind, type) and issubclass(kind, SessionRun)):
            raise ConfigError(f"kind: expected SessionRun or a subclass of it; got {shown(kind)}")
        if self.variation != "none" and not issubclass(kind, VariedSessionRun):
            raise ConfigError(f"variation needs a subclass of VariedSessionRun; got {kind.__name__}")
        log = None if rerun is None else path_of(rerun, "rerun")
        if out is None:
            if resume or video:
                raise ConfigError("resume and video need the folder out; got out=None")
            return SessionResult(self.config, *run_in_memory(self.config, progress, kind, _rerun_log(log, False)))
        with as_arguments():
            options = LoggedSessionOptions(path_of(out, "out"), resume, video, video_every, checkpoint_minutes, log)
        summary = run_logged(self.config, options, progress, kind)
        return SessionResult(self.config, summary, SessionFolder(options.out))


def run_logged(
    config: SessionConfig,
    options: LoggedSessionOptions,
    progress: Callable[[SessionRun], object] = lambda session: None,
    kind: type[SessionRun] = SessionRun,
) -> SessionSummary:
    """Run a session in a folder, with a log for Rerun's viewer if ``options.rerun`` names one.

    Arguments and errors are those of :func:`~jointattn_mj.gaze_following.run.run_session`.

    Raises:
        ExtraError: A log is asked for, and the package that writes it is missing.
    """
    return run_session(config, options, progress, kind, _rerun_log(options.rerun, options.resume))


def _rerun_log(path: Path | None, resume: bool) -> tuple[Watcher, ...]:
    """What writes a log into a file that is not there yet; a resumed session's next part gets a name of its own."""
    if path is None:
        return ()
    _check_suffix(path)
    extra("rerun", "rerun")
    from jointattn_mj.adapters.rerun import SessionLog

    if path.exists() and not resume:
        raise OutputError(f"{path} is already there; choose another file")
    make_room(path)
    return (lambda session: SessionLog(free_name(path), session),)


def _check_suffix(path: Path | None) -> None:
    if path is not None and path.suffix != ".rrd":
        raise ConfigError(f"rerun must be a file that ends in .rrd, as its viewer expects; got {path}")
