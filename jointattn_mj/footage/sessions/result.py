"""What a session before a person leaves in a folder."""

from dataclasses import dataclass

from jointattn_mj.footage.sessions.config import FootageSessionConfig
from jointattn_mj.footage.sessions.summary import FootageSessionSummary
from jointattn_mj.gaze_following.result import FinishedSession


@dataclass(frozen=True, eq=False, repr=False)
class FootageSessionResult(FinishedSession[FootageSessionConfig, FootageSessionSummary]):
    """A session before a recorded or present person: summary, tables, and what the robot learned.

    ``SessionResult.open`` gives it for the folder of such a session.

    Attributes:
        config: What decided the session.
        summary: The session in numbers.
        folder: Where the results lie.
    """

    def _object_names(self) -> tuple[str, ...]:
        return self.config.names

    def _last_minute(self) -> float:
        """By the clock of the video or camera, in whose frames faces were learned first."""
        return float(self.frames["time_s"][-1]) / 60
