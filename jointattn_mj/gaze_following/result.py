"""What a session leaves: tables, summary and weights, in memory or in a folder."""

from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import ClassVar, Generic, Protocol, TypeVar

import numpy as np

from jointattn_mj.gaze_following.agent import RobotConfig
from jointattn_mj.gaze_following.shifts import ShiftRow, Shifts
from jointattn_mj.io.files import claimed
from jointattn_mj.io.former_names import present_name
from jointattn_mj.io.progress import count
from jointattn_mj.io.provenance import write_config
from jointattn_mj.io.table import Table
from jointattn_mj.io.weights import read_weights, write_weights
from jointattn_mj.options import path_of
from jointattn_mj.perception.som import SOM


class AnySessionConfig(Protocol):
    """What the configs of all sessions have."""

    @property
    def robot(self) -> RobotConfig:
        """The robot's attention, learning and gaze control."""


class AnySessionSummary(Protocol):
    """What the summaries of all sessions have."""

    @property
    def minutes(self) -> float:
        """Length of the session."""

    @property
    def gaze_shifts(self) -> int:
        """Gaze shifts from the face to an object."""

    @property
    def successes(self) -> int | None:
        """How many of them were a success; None where that is not known."""

    @property
    def success_rate(self) -> float | None:
        """Share of gaze shifts that were a success; None where that is not known."""

    def write(self, path: Path) -> None:
        """Write ``summary.json``."""


SessionConfigT = TypeVar("SessionConfigT", bound=AnySessionConfig)
SessionSummaryT = TypeVar("SessionSummaryT", bound=AnySessionSummary)


@dataclass(frozen=True)
class SessionInMemory:
    """Tables and weights of a session that left no files."""

    frames: Table
    shifts: Table
    weights: dict[str, np.ndarray]
    folder: ClassVar[None] = None


@dataclass(frozen=True)
class SessionFolder:
    """Tables and weights in the folder of a session, read when they are first asked for."""

    folder: Path

    @cached_property
    def frames(self) -> Table:
        """See ``FinishedSession``."""
        return Table.read(self.folder / "frames.parquet", present_name)

    @cached_property
    def shifts(self) -> Table:
        """See ``FinishedSession``."""
        return Table.read(self.folder / "gaze_shifts.parquet", present_name)

    @cached_property
    def weights(self) -> dict[str, np.ndarray]:
        """See ``FinishedSession``."""
        return read_weights(self.folder / "weights.npz")


@dataclass(frozen=True, eq=False, repr=False)
class FinishedSession(Generic[SessionConfigT, SessionSummaryT]):
    """Base of the results of sessions: what the caregiver is decides the classes of config and summary.

    Two results are equal if config, summary, tables and weights are; the computing time does not count.

    Attributes:
        config: What decided the session.
        summary: The session in numbers.
        folder: Where the results lie; None for a result in memory.
    """

    config: SessionConfigT
    summary: SessionSummaryT
    _parts: SessionInMemory | SessionFolder

    @property
    def folder(self) -> Path | None:
        """Where the results lie; None for a result in memory."""
        return self._parts.folder

    @property
    def frames(self) -> Table:
        """A row a frame: the scene, what the robot perceived, and the interest of every candidate."""
        return self._parts.frames

    @property
    def shifts(self) -> Table:
        """A row a gaze shift: from where to where, who commanded it, and whether it was a success."""
        return self._parts.shifts

    @property
    def weights(self) -> dict[str, np.ndarray]:
        """What the robot learned, arrays by name: the map of faces, the map from faces to commands, and l of eq. 6.8.

        ``weights.npz`` in the result's folder holds them; ``start_from`` begins another session with it.
        """
        return self._parts.weights

    def save(self, folder: str | PathLike[str]) -> None:
        """Leave the result in a folder, as the command ``jointattn session`` does, but for its checkpoint.

        Args:
            folder: Is made when missing, and refused when it holds another run.

        Raises:
            OutputError: The folder holds another run, or cannot be written.

        Examples:
            >>> from jointattn_mj import Session
            >>> result = Session(minutes=0.1, perception="state").run()
            >>> result.save("out/kept_session")
        """
        from jointattn_mj.gaze_following import figures  # matplotlib takes long to import

        out = path_of(folder, "folder")
        with claimed(out):
            write_config(out / "config.yaml", self.config)
            self.frames.write(out / "frames.parquet")
            self.shifts.write(out / "gaze_shifts.parquet")
            write_weights(out / "weights.npz", self.weights)
            if self.summary.successes is not None:
                figures.draw_success(out / "success.png", self._shift_rows(), self._last_minute())
            som = {name.removeprefix("som_"): array for name, array in self.weights.items() if name.startswith("som_")}
            som_of_weights = SOM.from_arrays(som, self.config.robot.som, standardises="mean_face" not in self.weights)
            figures.draw_som(out / "som.png", som_of_weights)
            self.summary.write(out / "summary.json")

    def _shift_rows(self) -> Shifts:
        """The table of shifts in the form that figures are drawn from."""
        shifts = Shifts((*self._object_names(), "face"))
        for row in self.shifts.arrow.to_pylist():
            shifts.append(ShiftRow(**row))
        return shifts

    def _object_names(self) -> tuple[str, ...]:
        """Names of the objects that the robot can look at."""
        raise NotImplementedError

    def _last_minute(self) -> float:
        """When the session ended, minutes on the clock of its tables."""
        raise NotImplementedError

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, FinishedSession):
            return NotImplemented
        return (
            (self.config, self.summary) == (other.config, other.summary)
            and (self.shifts, self.frames) == (other.shifts, other.frames)
            and self.weights.keys() == other.weights.keys()
            and all(np.array_equal(array, other.weights[name]) for name, array in self.weights.items())
        )

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        summary = self.summary
        rate = "" if summary.success_rate is None else f", {summary.success_rate:.0%} successes"
        where = "in memory" if self.folder is None else f"in {self.folder}"
        return f"SessionResult({summary.minutes:g} min, {count(summary.gaze_shifts, 'gaze shift')}{rate}, {where})"
