"""The result of a session from Python, of a folder too: with the caregiver of chapter 6, or before a person."""

from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jointattn_mj.gaze_following.result import FinishedSession, SessionFolder
from jointattn_mj.gaze_following.session import SessionConfig
from jointattn_mj.gaze_following.summary import SessionSummary
from jointattn_mj.gaze_following.varied_session import VariedSessionConfig
from jointattn_mj.io.configs import read_config, values_in
from jointattn_mj.io.kinds import check_kind
from jointattn_mj.options import path_of

if TYPE_CHECKING:
    from jointattn_mj.footage.sessions.result import FootageSessionResult


@dataclass(frozen=True, eq=False, repr=False)
class SessionResult(FinishedSession[SessionConfig, SessionSummary]):
    """A finished session of gaze following: summary, tables, and what the robot learned.

    Tables and weights of a result that lies in a folder are read from there when they are first asked for. Two results
    are equal if config, summary, tables and weights are; the computing time does not count.

    Attributes:
        config: What decided the session.
        summary: The session in numbers.
        folder: Where the results lie; None for a result in memory.

    Examples:
        >>> from jointattn_mj import Session, SessionResult
        >>> result = Session(minutes=0.5, perception="state").run()
        >>> result.save("out/half_a_minute")
        >>> SessionResult.open("out/half_a_minute") == result
        True
        >>> len(result.frames)
        900
        >>> result.frames.to_pandas()["phase"].iloc[0]
        'observe'
    """

    @classmethod
    def open(cls, folder: str | PathLike[str]) -> "SessionResult | FootageSessionResult":
        """The result of a session that has finished in ``folder``.

        Args:
            folder: What ``--out`` or ``run(out=...)`` named, or ``save``; of a session with ``--world video`` or
                ``--world camera``, too.

        Returns:
            The result, equal to the one that the session returned. Of a session before a person it is a
            ``FootageSessionResult``, with config and summary of their own.

        Raises:
            OutputError: The folder holds no finished session.
            ConfigError: Its config.yaml cannot be read.

        Examples:
            >>> from jointattn_mj import Session, SessionResult
            >>> result = Session(minutes=0.1, perception="state").run(out="out/session")
            >>> SessionResult.open("out/session") == result
            True
        """
        path = path_of(folder, "folder")
        check_kind(path, SessionResult.__name__)
        config = path / "config.yaml"
        values = values_in(config) if config.exists() else {}
        if "video_file" in values or "camera" in values:
            return _before_a_person(path, values)
        summary = SessionSummary.read(path / "summary.json")
        return cls(read_config(config, VariedSessionConfig), summary, SessionFolder(path))

    def _object_names(self) -> tuple[str, ...]:
        return tuple(item.name for item in self.config.world.scene.objects)

    def _last_minute(self) -> float:
        """By the robot's clock, on which nothing comes before the session."""
        return self.config.minutes


def _before_a_person(folder: Path, values: Mapping[str, Any]) -> "FootageSessionResult":
    """The result of a session before a person, with what such sessions import: most need none of it.

    Args:
        folder: Of the session.
        values: Of its config.yaml.
    """
    from jointattn_mj.footage.sessions.config import CameraSessionConfig, VideoSessionConfig
    from jointattn_mj.footage.sessions.result import FootageSessionResult
    from jointattn_mj.footage.sessions.summary import FootageSessionSummary

    kind = VideoSessionConfig if "video_file" in values else CameraSessionConfig
    summary = FootageSessionSummary.read(folder / "summary.json")
    return FootageSessionResult(read_config(folder / "config.yaml", kind), summary, SessionFolder(folder))
