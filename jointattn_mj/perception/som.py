"""Self-organising map of face patterns (section 6.3.3, Figs. 6.4 and 6.6; reference [24] of the dissertation).

The map is a sheet of 9x9 units, each with a pattern. Every face pulls the most similar unit towards itself, and its
neighbours on the sheet less so; pull and neighbourhood shrink with time. Similar faces then have neighbouring units. A
face is described by its similarity to each unit: 81 activations, the input of the learner.

Patterns are standardised (zero mean, unit variance), so that brightness and contrast do not count. A pattern of fewer
than four numbers is a measured quantity (yaw and pitch, with perception from the state), and is taken as it is. So are
deviations from a mean face: how large they are says how far the face is turned.
"""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from jointattn_mj.errors import ConfigError, ObservationError
from jointattn_mj.guards.border import numbers
from jointattn_mj.options import Checked, Count, Real, Whole

IMAGE_DIMENSION = 4  # inputs with at least so many numbers are patterns, and are standardised


@dataclass(frozen=True)
class SOMConfig(Checked):
    """Options of the map. Section 6.4.1 fixes 9x9 units, 32x32 grey patterns, and three minutes of learning."""

    rows: Annotated[int, Whole("[1, 64]")] = 9
    """Units along one side of the sheet (section 6.4.1)."""
    columns: Annotated[int, Whole("[1, 64]")] = 9
    """Units along the other side."""
    updates: Count = 1800
    """Patterns over which the schedules run: three minutes (section 6.4.1) at ten a second."""
    sigma_start: Annotated[float, Real("[0.01, 1000]")] = 4.0
    """Standard deviation of the Gaussian neighbourhood at first, in steps on the sheet: nearly half of it."""
    sigma_end: Annotated[float, Real("[0.01, 1000]")] = 0.7
    """The same at the end: neighbours still learn a third of what a unit learns, so that the sheet stays smooth."""
    rate_start: Annotated[float, Real("[1e-9, 1]")] = 0.5
    """Share of the difference that the most similar unit learns, at first."""
    rate_end: Annotated[float, Real("[1e-9, 1]")] = 0.05
    """The same at the end; both schedules are exponential."""
    softness: Annotated[float, Real("[1e-6, 1e6]")] = 0.3
    """Width of the activations, relative to the mean squared distance of neighbouring units: small is
    winner-takes-all, large is flat. The dissertation says "activations ... based on the similarity"."""

    ADVANCED: ClassVar = ("rate_end",)


def pattern_of(x: np.ndarray, size: int, standardises: bool = True) -> np.ndarray:
    """``x`` as a pattern (size,) float32.

    Args:
        x: ``size`` numbers, in any shape.
        size: How many numbers a pattern has.
        standardises: Whether it is standardised.

    Raises:
        ObservationError: NaN, infinity, or no numbers.
        ConfigError: Another number of them.
    """
    given = numbers("pattern", x)
    pattern = standardised(given) if standardises else given.astype(np.float32).ravel()
    if pattern.size != size:
        raise ConfigError(f"expected face patterns of {size} numbers; got {pattern.size}")
    return pattern


def standardised(x: np.ndarray) -> np.ndarray:
    """``x`` as (d,) float32; from four numbers on with zero mean and unit variance, zeros if it is flat."""
    flat = np.asarray(x, np.float32).ravel()
    if flat.size < IMAGE_DIMENSION:
        return flat
    centred = flat - flat.mean()
    spread = float(np.sqrt(np.dot(centred, centred) / flat.size))
    return centred / spread if spread > 1e-6 * max(1.0, float(np.abs(flat).max())) else np.zeros_like(flat)


MOST_COUNTED = 10**9
"""No robot has seen so many patterns, and tables hold such numbers."""


def whole_number(name: str, value: np.ndarray) -> int:
    """A count from a file, called ``name`` in messages.

    Raises:
        ConfigError: It is no whole number from 0 to ``MOST_COUNTED``.
    """
    if np.shape(value) or np.asarray(value).dtype.kind not in "iu" or not 0 <= value <= MOST_COUNTED:
        given = " ".join(str(value).split())
        raise ConfigError(f"{name}: expected a whole number from 0 to {MOST_COUNTED:,}; got {given:.80}")
    return int(value)


class SOM:
    """A map that learns pattern by pattern. It can be pickled.

    Attributes:
        config: Its options.
        weights: (units, d) float32, the units' patterns; unit ``row * columns + column``.
        n_patterns: Patterns learned so far.
        standardises: Whether patterns are standardised before they are compared.
    """

    def __init__(
        self,
        dimension: int,
        config: SOMConfig | None = None,
        rng: np.random.Generator | None = None,
        standardises: bool = True,
    ):
        """Make a map that has learned nothing.

        Args:
            dimension: Numbers in a pattern, d.
            config: Options.
            rng: Draws the first weights, small noise; None leaves them at zero, to be loaded.
            standardises: Whether patterns are standardised before they are compared.
        """
        self.config = config or SOMConfig()
        self.standardises = standardises
        units = self.config.rows * self.config.columns
        self.weights = np.zeros((units, dimension), np.float32)
        if rng is not None:
            self.weights += rng.normal(0.0, 0.1, self.weights.shape).astype(np.float32)
        self.n_patterns = 0
        row_column = np.stack(np.divmod(np.arange(units), self.config.columns), axis=1)
        between = row_column[:, None] - row_column[None]
        self._grid_distance = np.square(between).sum(axis=2).astype(np.float32)  # squared, on the sheet
        self._width: float | None = None
        self._norms: np.ndarray | None = None

    def __repr__(self) -> str:
        rows, columns, dimension = self.config.rows, self.config.columns, self.weights.shape[1]
        return f"SOM({rows}x{columns} units of {dimension} numbers, {self.n_patterns} patterns learned)"

    def update(self, x: np.ndarray) -> int:
        """Learn one pattern.

        Args:
            x: d numbers, in any shape.

        Returns:
            Index of the most similar unit.

        Raises:
            ObservationError: NaN, infinity, or no numbers.
            ConfigError: Another number of them than the units have.
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
        """Learn from stored patterns, drawn at random, until the schedules are over.

        Args:
            patterns: (n, ...) one or more, d numbers each.
            rng: Draws them.

        Raises:
            ObservationError: There are none, or some are not finite.
        """
        if not len(patterns):
            raise ObservationError("patterns: expected one or more to learn from; got none")
        prepared = np.stack([self._pattern(x) for x in patterns])
        for index in rng.integers(len(prepared), size=max(0, self.config.updates - self.n_patterns)):
            self.update(prepared[index])

    def activations(self, x: np.ndarray, softness: float | None = None) -> np.ndarray:
        """Similarity of a pattern to each unit: (units,), summing to 1.

        It is exp(-d^2 / (2 w^2)) before it is normalised, where d is the distance to a unit's pattern, and w^2 is
        ``softness`` times the mean squared distance of neighbouring units. So a face activates its unit and those
        around it, whatever the map was trained on.

        Args:
            x: The pattern, d numbers.
            softness: In place of the config's.
        """
        excess = self._excess(x)
        excess -= excess.min()
        active = np.exp(excess / (-2 * (softness or self.config.softness) * self.width))
        shares: np.ndarray = active / active.sum()
        return shares

    @property
    def width(self) -> float:
        """Mean squared distance between the patterns of units that are neighbours along a row or a column."""
        if self._width is None:
            first, second = np.nonzero(np.triu(self._grid_distance == 1))
            between = np.square(self.weights[first] - self.weights[second]).sum(axis=1)
            self._width = float(between.mean()) if len(between) and between.mean() > 0 else 1.0
        return self._width

    def winner(self, x: np.ndarray) -> int:
        """Index of the unit that is most similar to a pattern (d numbers)."""
        return int(self._excess(x).argmin())

    def quantisation_error(self, patterns: np.ndarray) -> float:
        """Mean distance from each of ``patterns`` (n, ...) to its most similar unit."""
        return float(np.mean([np.sqrt(self._distances(x).min()) for x in patterns]))

    def topographic_error(self, patterns: np.ndarray) -> float:
        """Share of ``patterns`` (n, ...) whose two most similar units do not touch on the sheet; diagonals count."""
        nearest = np.array([np.argsort(self._distances(x), kind="stable")[:2] for x in patterns])
        return float(np.mean(self._grid_distance[nearest[:, 0], nearest[:, 1]] > 2))

    def images(self) -> np.ndarray:
        """The units' patterns as images (rows, columns, side, side): Fig. 6.6.

        Raises:
            ConfigError: Patterns are no square images.
        """
        side = round(self.weights.shape[1] ** 0.5)
        if side * side != self.weights.shape[1]:
            raise ConfigError(f"som: expected square patterns to show; got {self.weights.shape[1]} numbers a unit")
        return self.weights.reshape(self.config.rows, self.config.columns, side, side)

    def arrays(self) -> dict[str, np.ndarray]:
        """All that was learned, for ``np.savez``."""
        return {"weights": self.weights.copy(), "seen": np.array(self.n_patterns)}

    @classmethod
    def from_arrays(
        cls, arrays: dict[str, np.ndarray], config: SOMConfig | None = None, standardises: bool = True
    ) -> "SOM":
        """Make a map from what ``arrays`` gave.

        Args:
            arrays: ``weights`` (units, d), and ``seen``, the number of patterns learned.
            config: Options; rows and columns must be those of the weights.
            standardises: Whether patterns are standardised before they are compared.

        Raises:
            ConfigError: The weights belong to another sheet, or are not finite.
        """
        with np.errstate(over="ignore"):
            weights = np.asarray(arrays["weights"], np.float32)
        som = cls(weights.shape[-1] if weights.ndim else 0, config, standardises=standardises)
        if weights.shape != som.weights.shape or not np.isfinite(weights).all():
            raise ConfigError(
                f"som: expected weights {som.weights.shape} of finite numbers, for {som.config.rows}x"
                f"{som.config.columns} units (another som.rows or som.columns?); got {weights.shape}"
            )
        som.weights[:] = weights
        som.n_patterns = whole_number("seen", arrays["seen"])
        return som

    def _pattern(self, x: np.ndarray) -> np.ndarray:
        return pattern_of(x, self.weights.shape[1], self.standardises)

    def _excess(self, x: np.ndarray) -> np.ndarray:
        """Squared distances (units,) less a constant, worked out without arrays as large as the map."""
        if self._norms is None:
            self._norms = np.einsum("ij,ij->i", self.weights, self.weights)
        excess: np.ndarray = self._norms - 2 * (self.weights @ self._pattern(x))
        return excess

    def _distances(self, x: np.ndarray) -> np.ndarray:
        """Squared distances (units,)."""
        difference = self.weights - self._pattern(x)
        distances: np.ndarray = np.einsum("ij,ij->i", difference, difference)
        return distances
