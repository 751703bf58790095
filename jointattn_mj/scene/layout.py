"""Where objects lie on the table: apart from each other, and in the long run evenly spread (section 6.4.2)."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.options import Checked, Metres, Real, Whole

TRIES = 2000  # random positions tried for one object
AT_ONCE = 100  # of them at a time; the first are enough on any but a crowded table
FILLS = 20  # tables tried before giving up


@dataclass(frozen=True)
class LayoutConfig(Checked):
    """The part of the table that objects are put on; world frame, metres."""

    x_range: tuple[Metres, Metres] = (0.90, 1.12)
    """Near and far edge, seen from the robot. The caregiver's arm reaches all between, and the robot sees it while it
    looks at the caregiver's face."""
    y_range: tuple[Metres, Metres] = (-0.36, 0.36)
    """Right and left edge; from the caregiver's face, gaze directions of about 40 degrees to either side."""
    spacing: Annotated[float, Real("(0, 10]")] = 0.13
    """Least distance of two objects' centres, metres: twice an object's width, so that a hand fits between."""
    evenness: Annotated[int, Whole("[1, 2000]")] = 24
    """Of so many random positions the one in the least used cell is taken: "positions as even as possible" (6.4.2).
    1 draws uniformly."""
    cells: tuple[Annotated[int, Whole("[1, 1000]")], Annotated[int, Whole("[1, 1000]")]] = (3, 8)
    """Numbers of cells in x and y whose use is counted for ``evenness``."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("x_range", "y_range"):
            low, high = getattr(self, name)
            if not low < high:
                raise ConfigError(f"layout.{name} must be a lower and a higher number; got {low}, {high}")


class Layout:
    """Draws positions, and counts how often each cell of the table was used."""

    def __init__(self, config: LayoutConfig, rng: np.random.Generator):
        self.config = config
        self._rng = rng
        self._low = np.array([config.x_range[0], config.y_range[0]])
        self._size = np.array([config.x_range[1], config.y_range[1]]) - self._low
        self._used = np.zeros(config.cells, int)

    def draw(self, others: np.ndarray) -> np.ndarray:
        """Draw a position on the table.

        Args:
            others: (k, 2) positions of the other objects, world frame, metres.

        Returns:
            (2,) at least ``spacing`` away from ``others``, world frame, metres.

        Raises:
            ConfigError: The table is too full for the spacing.
        """
        free = self._free(others)
        if not len(free):
            raise self._full(len(others) + 1)
        return self._least_used(free)

    def _free(self, others: np.ndarray) -> np.ndarray:
        """Up to ``evenness`` random positions (m, 2) that are far enough from ``others`` (k, 2)."""
        free, draws = np.empty((0, 2)), self._low + self._size * self._rng.random((TRIES, 2))
        for first in range(0, TRIES, AT_ONCE):
            drawn = draws[first : first + AT_ONCE]
            apart = np.linalg.norm(drawn[:, None] - np.reshape(others, (1, -1, 2)), axis=2)
            free = np.vstack([free, drawn[np.all(apart >= self.config.spacing, axis=1)]])
            if len(free) >= self.config.evenness:
                break
        return free[: self.config.evenness]

    def _least_used(self, free: np.ndarray) -> np.ndarray:
        cells = ((free - self._low) / self._size * self.config.cells).astype(int)
        chosen = int(np.argmin(self._used[tuple(cells.T)]))
        self._used[tuple(cells[chosen])] += 1
        position: np.ndarray = free[chosen]
        return position

    def _full(self, count: int) -> ConfigError:
        return ConfigError(
            f"no room for {count} objects with a spacing of {self.config.spacing} m on "
            f"{self._size[0]:.2f} x {self._size[1]:.2f} m; use fewer objects, a smaller spacing or a larger range"
        )

    def fill(self, count: int) -> np.ndarray:
        """Draw positions (count, 2) of all objects, world frame, metres.

        Raises:
            ConfigError: So many objects do not fit.
        """
        for _ in range(FILLS):
            positions = np.empty((0, 2))
            for _ in range(count):
                free = self._free(positions)
                if not len(free):
                    break
                positions = np.vstack([positions, self._least_used(free)])
            else:
                return positions
        raise self._full(count)
