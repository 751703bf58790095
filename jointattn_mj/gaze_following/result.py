"""What a session leaves: tables, summary and weights, in memory or in a folder."""

from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from os import PathLike
from pathlib import Path
from typing import ClassVar

import numpy as np

from jointattn_mj.gaze_following.session import SessionConfig
from jointattn_mj.gaze_following.shifts import ShiftRow, Shifts
from jointattn_mj.gaze_following.summary import SessionSummary
from jointattn_mj.gaze_following.varied_session import VariedSessionConfig
from jointattn_mj.io.configs import read_config, values_in
from jointattn_mj.io.files import claimed
from jointattn_mj.io.former_columns import present_name
from jointattn_mj.io.kinds import check_kind
from jointattn_mj.io.progress import count
from jointattn_mj.io.provenance import write_config
from jointattn_mj.io.table import Table
from jointattn_mj.io.weights import read_weights, write_weights
from jointattn_mj.options import path_of
from jointattn_mj.perception.som import SOM

FOOTAGE = "jointattn_mj.footage.sessions.result"
"""Module for folders of sessions before a person. It lies above this one, and is looked up when it is needed."""


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
        """See ``SessionResult``."""
        return Table.read(self.folder / "frames.parquet", present_name)

    @cached_property
    def shifts(self) -> Table:
        """See ``SessionResult``."""
        return Table.read(self.folder / "gaze_shifts.parquet", present_name)

    @cached_property
    def weights(self) -> dict[str, np.ndarray]:
        """See ``SessionResult``."""
        return read_weights(self.folder / "weights.npz")


@dataclass(frozen=True, eq=False, repr=False)
class SessionResult:
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

    config: SessionConfig
    summary: SessionSummary
    _parts: SessionInMemory | SessionFolder

    @classmethod
    def open(cls, folder: str | PathLike[str]) -> "SessionResult":
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
        if config.exists() and {"video_file", "camera"} & values_in(config).keys():
            footage: SessionResult = import_module(FOOTAGE).footage_result(path)
            return footage
        summary = SessionSummary.read(path / "summary.json")
        return cls(read_config(config, VariedSessionConfig), summary, SessionFolder(path))

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
            figures.draw_som(out / "som.png", SOM.from_arrays(som, self.config.robot.som))
            self.summary.write(out / "summary.json")

    def _shift_rows(self) -> Shifts:
        """The table of shifts in the form that figures are drawn from."""
        shifts = Shifts((*self._object_names(), "face"))
        for row in self.shifts.arrow.to_pylist():
            shifts.append(ShiftRow(**row))
        return shifts

    def _object_names(self) -> tuple[str, ...]:
        """Of the objects."""
        return tuple(item.name for item in self.config.world.scene.objects)

    def _last_minute(self) -> float:
        """When the session ended."""
        return self.config.minutes

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, SessionResult):
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
