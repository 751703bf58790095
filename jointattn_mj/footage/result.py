"""What watching a video leaves in a folder: percepts, fixations, faces, and a summary."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

from jointattn_mj.footage.colours import candidate_names
from jointattn_mj.footage.config import PerceiveConfig
from jointattn_mj.footage.frames import PerceivedFrame, frames_of
from jointattn_mj.footage.run import read_summary
from jointattn_mj.io.configs import read_config
from jointattn_mj.io.former_names import present_name
from jointattn_mj.io.kinds import check_kind
from jointattn_mj.io.progress import count
from jointattn_mj.io.table import Table
from jointattn_mj.options import path_of


@dataclass(frozen=True, eq=False, repr=False)
class PerceptionResult:
    """A video that was watched. Iterating gives its frames, as ``perceive`` does without a folder, but for their flow.

    Tables are read when they are first asked for. Two results are equal if config, tables and summary are, but for the
    computing time in it.

    Attributes:
        config: What decided what was perceived.
        summary: The viewing in numbers, as in ``summary.json``.
        folder: Where the results lie.

    Examples:
        >>> from jointattn_mj import PerceptionResult, perceive
        >>> perceive("out/clip.mp4", out="out/perceived", overlay=False)
        PerceptionResult(2.0 s of clip.mp4, face in 100%, 1 fixation, in out/perceived)
        >>> result = PerceptionResult.open("out/perceived")
        >>> list(result)[-1].fixation
        'face'
    """

    config: PerceiveConfig
    summary: dict[str, Any]
    folder: Path

    @classmethod
    def open(cls, folder: str | PathLike[str]) -> "PerceptionResult":
        """The result in ``folder``, of a video that was watched to its end or stopped.

        Args:
            folder: What ``--out`` or ``perceive(out=...)`` named.

        Returns:
            The result, equal to the one that ``perceive`` returned.

        Raises:
            OutputError: The folder holds no results of a video.
            ConfigError: Its config.yaml cannot be read.

        Examples:
            >>> from jointattn_mj import PerceptionResult, perceive
            >>> _ = perceive("out/clip.mp4", out="out/perceived_again", overlay=False)
            >>> PerceptionResult.open("out/perceived_again").summary["fixations"]
            1
        """
        path = path_of(folder, "folder")
        check_kind(path, cls.__name__)
        return cls(read_config(path / "config.yaml", PerceiveConfig), read_summary(path), path)

    @cached_property
    def percepts(self) -> Table:
        """A row a frame: where face and objects were, what moved, and the interest of each."""
        return Table.read(self.folder / "percepts.parquet", present_name)

    @cached_property
    def fixations(self) -> Table:
        """A row a fixation: what was looked at, from when to when, and where it was."""
        return Table.read(self.folder / "fixations.parquet", present_name)

    @cached_property
    def faces(self) -> Table | None:
        """A row a face pattern: its unit of the self-organising map; None where no face was detected."""
        path = self.folder / "faces.parquet"
        return Table.read(path) if path.exists() else None

    @cached_property
    def people(self) -> Table | None:
        """A row a face in an image: box, landmarks, score, yaw, and who it is; None with the detector templates."""
        path = self.folder / "people.parquet"
        return Table.read(path) if path.exists() else None

    @cached_property
    def looks(self) -> Table | None:
        """A row a look: where the person of interest looks, with its probability; None without ``looks``."""
        path = self.folder / "looks.parquet"
        return Table.read(path) if path.exists() else None

    @property
    def overlay(self) -> Path | None:
        """The video with everything that was perceived drawn on it, if there is one."""
        path = self.folder / "overlay.mp4"
        return path if path.exists() else None

    def __iter__(self) -> Iterator[PerceivedFrame]:
        names = candidate_names(self.config.objects, self.config.areas_each)
        return frames_of(self.percepts, (*names, "face"))

    def __len__(self) -> int:
        return int(self.summary["frames"])

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, PerceptionResult):
            return NotImplemented
        numbers = [{**result.summary, "wall_seconds": 0.0} for result in (self, other)]
        return (
            self.config == other.config
            and numbers[0] == numbers[1]
            and (self.percepts, self.fixations, self.faces, self.people, self.looks)
            == (other.percepts, other.fixations, other.faces, other.people, other.looks)
        )

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        summary = self.summary
        fixations = count(summary["fixations"], "fixation")
        return (
            f"PerceptionResult({summary['watched_seconds']:.1f} s of {self.config.video.name}, "
            f"face in {summary['detected']['face']:.0%}, {fixations}, in {self.folder})"
        )
