"""What a session before a person leaves in a folder; ``SessionResult.open`` gives it for such a folder."""

from dataclasses import dataclass
from pathlib import Path

from jointattn_mj.footage.sessions.config import CameraSessionConfig, FootageSessionConfig, VideoSessionConfig
from jointattn_mj.footage.sessions.summary import FootageSessionSummary
from jointattn_mj.gaze_following.result import SessionFolder, SessionResult
from jointattn_mj.io.configs import config_of, values_in


@dataclass(frozen=True, eq=False, repr=False)
class FootageSessionResult(SessionResult):
    """A session before a recorded or present person: summary, tables, and what the robot learned.

    Attributes:
        config: What decided the session.
        summary: The session in numbers.
        folder: Where the results lie.
    """

    config: FootageSessionConfig  # type: ignore[assignment]
    summary: FootageSessionSummary  # type: ignore[assignment]

    def _object_names(self) -> tuple[str, ...]:
        return self.config.names

    def _last_minute(self) -> float:
        """By the clock of the video or camera, in whose frames faces were learned first."""
        return float(self.frames["time_s"][-1]) / 60


def footage_result(path: Path) -> FootageSessionResult:
    """The result in a folder.

    Raises:
        OutputError: Its summary.json is missing or damaged.
        ConfigError: Its config.yaml cannot be read.
    """
    values = values_in(path / "config.yaml")
    kind = VideoSessionConfig if "video_file" in values else CameraSessionConfig
    summary = FootageSessionSummary.read(path / "summary.json")
    return FootageSessionResult(config_of(kind, values), summary, SessionFolder(path))
