"""Where the person of a video looks, as somebody has coded it: what success of the robot is held against."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.footage.looks.check import Codings

NO_OBJECT, UNKNOWN = -1, -2
"""What the person looks at, where that is none of the objects, and where nobody has said it."""
EVENTS = "events.csv"
"""File of a run of perceive with the tier "looks at"."""


@dataclass(frozen=True)
class CodedLooks:
    """Looks of a person by time.

    Attributes:
        onsets: (n,) when each begins, s, in order.
        offsets: (n,) when it ends.
        targets: (n,) number of the object, or NO_OBJECT.
    """

    onsets: np.ndarray
    offsets: np.ndarray
    targets: np.ndarray

    @classmethod
    def read(cls, path: Path, names: tuple[str, ...]) -> "CodedLooks":
        """Read a coding.

        Args:
            path: A file that ``jointattn measure`` reads with one tier, or one called "looks at"; or the folder of a
                run of ``perceive --looks``. Codes are names of objects; any other is a look at none of them. Time
                without a code, or with "unsure", "turn" or "cannot be seen", is not known.
            names: Of the objects.

        Raises:
            SeriesError: It cannot be read.
            ConfigError: None of its codes is an object.
        """
        looks = Codings.read(path / EVENTS if path.is_dir() else path).looks
        codes = sorted({code for _, _, code in looks})
        if not codes:
            raise ConfigError(f"{path} says of no time where the person looks")
        if not set(codes) & set(names):
            raise ConfigError(
                f"{path} names none of the objects ({', '.join(names)}); its codes are "
                f"{', '.join(codes)}: name the objects as they are coded, name=#colour"
            )
        order = sorted(looks)
        return cls(
            np.array([onset for onset, _, _ in order]),
            np.array([offset for _, offset, _ in order]),
            np.array([names.index(code) if code in names else NO_OBJECT for _, _, code in order], int),
        )

    def at(self, time_s: float) -> int:
        """Number of the object that is looked at then, NO_OBJECT, or UNKNOWN."""
        row = int(np.searchsorted(self.onsets, time_s + 1e-6, side="right")) - 1
        if row < 0 or time_s + 1e-6 >= self.offsets[row]:
            return UNKNOWN
        return int(self.targets[row])
