"""Self-organising map of face patterns (section 6.3.3, Figs. 6.4 and 6.6; reference [24] of the dissertation).

A sheet of 9x9 cells, each holding a pattern. Every face seen pulls the most similar cell, and its neighbours on the
sheet less, towards itself; pull and neighbourhood shrink with time. Afterwards similar faces have neighbouring cells,
and a face is described by how near it is to each cell: 81 activations, the input of the learner.

Patterns are standardised (zero mean, unit variance), so that brightness and contrast of the image do not count. Any
dimension works; below four it is a measured quantity rather than an image (the truth path: yaw and pitch), and is
taken as it is.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from jointattn_mj.errors import ConfigError, ObservationError
from jointattn_mj.guards.border import numbers
from jointattn_mj.options import Checked, Count, Real, Whole

IMAGE_DIMENSION = 4  # inputs with at least so many numbers are patterns, and are standardised


@dataclass(frozen=True)
class SOMConfig(Checked):
    """Options of the map. Section 6.4.1 fixes 9x9 cells, 32x32 grey patterns, and three minutes of learning."""

    rows: Annotated[int, Whole("[1, 64]")] = 9
    """Cells on one side of the sheet, section 6.4.1."""
    columns: Annotated[int, Whole("[1, 64]")] = 9
    """Cells on the other."""
    updates: Count = 1800
    """Patterns over which the schedules run: three minutes (section 6.4.1) at ten looks a second."""
    sigma_start: Annotated[float, Real("[0.01, 1000]")] = 4.0
    """Standard deviation of the Gaussian neighbourhood at first, in cells: nearly half the sheet."""
    sigma_end: Annotated[float, Real("[0.01, 1000]")] = 0.7
    """The same at the end: neighbours still share a third of what a cell learns, so that the sheet stays smooth."""
    rate_start: Annotated[float, Real("[1e-9, 1]")] = 0.5
    """Share of the difference that the best cell takes over, at first."""
    rate_end: Annotated[float, Real("[1e-9, 1]")] = 0.05
    """The same at the end; both schedules are exponential."""
    softness: Annotated[float, Real("[1e-6, 1e6]")] = 0.3
    """Width of the activations in units of the map's own: the mean squared distance between neighbouring cells. The
    dissertation says "activations ... based on the similarity"; small is winner-takes-all, large is flat."""


def standardised(x: np.ndarray) -> np.ndarray:
    """(d,) float32: ``x`` flattened; if it is a pattern, with zero mean and unit variance (zeros if it is flat)."""
    flat = np.asarray(x, np.float32).ravel()
    if flat.size < IMAGE_DIMENSION:
        return flat
    centred = flat - flat.mean()
    spread = float(np.sqrt(np.dot(centred, centred) / flat.size))
    return centred / spread if spread > 1e-6 * max(1.0, float(np.abs(flat).max())) else np.zeros_like(flat)


def whole_number(name: str, value: np.ndarray) -> int:
    """A stored count.

    Raises:
        ConfigError: It is no whole number of 0 or more.
    """
    if np.shape(value) or np.asarray(value).dtype.kind not in "iu" or value < 0:
        raise ConfigError(f"{name}: expected a whole number of 0 or more, came {' '.join(str(value).split()):.80}")
    return int(value)


class SOM:
    """A map that learns pattern by pattern.

    ``weights`` is (rows * columns, d) float32; cell ``row * columns + column``. It can be pickled.
    """

    def __init__(self, dimension: int, config: SOMConfig | None = None, rng: np.random.Generator | None = None):
        """``rng`` draws the first weights: small noise; without one all cells begin at zero (to be loaded)."""
        self.config = config or SOMConfig()
        cells = self.config.rows * self.config.columns
        self.weights = np.zeros((cells, dimension), np.float32)
        if rng is not None:
            self.weights += rng.normal(0.0, 0.1, self.weights.shape).astype(np.float32)
        self.n_patterns = 0
        location = np.stack(np.divmod(np.arange(cells), self.config.columns), axis=1)
        between = location[:, None] - location[None]
        self._grid_distance = np.square(between).sum(axis=2).astype(np.float32)  # squared, in cells
        self._width: float | None = None
        self._norms: np.ndarray | None = None

    def update(self, x: np.ndarray) -> int:
        """Learn one pattern; the index of the cell that won. Schedules go by the number of patterns seen so far.

        Raises:
            ObservationError: NaN, infinity, or no numbers.
            ConfigError: Another number of them than the cells have.
        """
        config = self.config
        pattern = self._pattern(x)
        progress = min(self.n_patterns / config.updates, 1.0)
        sigma = config.sigma_start * (config.sigma_end / config.sigma_start) ** progress
        rate = config.rate_start * (config.rate_end / config.rate_start) ** progress
        difference = pattern - self.weights
        winner = int(np.einsum("ij,ij->i", difference, difference).argmin())
        pull = rate * np.exp(self._grid_distance[winner] / (-2 * sigma * sigma))
        difference *= pull[:, None]
        self.weights += difference
        self.n_patterns += 1
        self._width = self._norms = None
        return winner

    def train(self, patterns: np.ndarray, rng: np.random.Generator) -> None:
        """Learn from stored ``patterns`` (n, ...), drawn at random, until the schedules are over."""
        if not len(patterns):
            raise ObservationError("patterns: expected one or more to learn from; got none")
        prepared = np.stack([self._pattern(x) for x in patterns])
        for index in rng.integers(len(prepared), size=max(0, self.config.updates - self.n_patterns)):
            self.update(prepared[index])

    def activations(self, x: np.ndarray) -> np.ndarray:
        """(rows * columns,) summing to 1: exp(-d^2 / (2 w^2)), d the distance to each cell's pattern.

        w^2 is ``softness`` times the mean squared distance between neighbouring cells, so that a face lights up its
        cell and those around it whatever the map was trained on.
        """
        excess = self._excess(x)
        excess -= excess.min()
        active = np.exp(excess / (-2 * self.config.softness * self.width))
        return active / active.sum()

    @property
    def width(self) -> float:
        """Mean squared distance between patterns of cells that are neighbours along a row or a column."""
        if self._width is None:
            first, second = np.nonzero(np.triu(self._grid_distance == 1))
            between = np.square(self.weights[first] - self.weights[second]).sum(axis=1)
            self._width = float(between.mean()) if len(between) and between.mean() > 0 else 1.0
        return self._width

    def winner(self, x: np.ndarray) -> int:
        """Index of the cell nearest to a pattern."""
        return int(self._excess(x).argmin())

    def quantisation_error(self, patterns: np.ndarray) -> float:
        """Mean distance from each of ``patterns`` (n, ...) to its nearest cell, standardised units."""
        return float(np.mean([np.sqrt(self._distances(x).min()) for x in patterns]))

    def topographic_error(self, patterns: np.ndarray) -> float:
        """Share of ``patterns`` (n, ...) whose nearest and second nearest cells do not touch (diagonals count)."""
        nearest = np.array([np.argsort(self._distances(x), kind="stable")[:2] for x in patterns])
        return float(np.mean(self._grid_distance[nearest[:, 0], nearest[:, 1]] > 2))

    def images(self) -> np.ndarray:
        """(rows, columns, side, side) the cells' patterns, if they are square images: Fig. 6.6."""
        side = round(self.weights.shape[1] ** 0.5)
        if side * side != self.weights.shape[1]:
            raise ConfigError(f"som: expected square patterns to show, came {self.weights.shape[1]} numbers a cell")
        return self.weights.reshape(self.config.rows, self.config.columns, side, side)

    def arrays(self) -> dict[str, np.ndarray]:
        """All that was learned, to be saved with ``np.savez``."""
        return {"weights": self.weights.copy(), "seen": np.array(self.n_patterns)}

    @classmethod
    def from_arrays(cls, arrays: dict[str, np.ndarray], config: SOMConfig | None = None) -> "SOM":
        """A map from what `arrays` gave.

        Raises:
            ConfigError: The weights are of another sheet than ``config``'s.
        """
        with np.errstate(over="ignore"):
            weights = np.asarray(arrays["weights"], np.float32)
        som = cls(weights.shape[-1], config)
        if weights.shape != som.weights.shape or not np.isfinite(weights).all():
            raise ConfigError(f"som: expected weights {som.weights.shape} of finite numbers, came {weights.shape}")
        som.weights[:] = weights
        som.n_patterns = whole_number("seen", arrays["seen"])
        return som

    def _pattern(self, x: np.ndarray) -> np.ndarray:
        pattern = standardised(numbers("pattern", x))
        if pattern.size != self.weights.shape[1]:
            raise ConfigError(f"som: expected patterns of {self.weights.shape[1]} numbers, came {pattern.size}")
        return pattern

    def _excess(self, x: np.ndarray) -> np.ndarray:
        """(rows * columns,) squared distances less a constant: without arrays as large as the map."""
        if self._norms is None:
            self._norms = np.einsum("ij,ij->i", self.weights, self.weights)
        return self._norms - 2 * (self.weights @ self._pattern(x))

    def _distances(self, x: np.ndarray) -> np.ndarray:
        """(rows * columns,) squared distances."""
        difference = self.weights - self._pattern(x)
        return np.einsum("ij,ij->i", difference, difference)
