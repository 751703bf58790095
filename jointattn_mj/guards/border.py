"""The border of compiled code, which looks numbers up wherever they point: Python passes it with what was checked.

A function behind it is called from compiled code as it is, at no cost.
"""

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numpy as np

from jointattn_mj.errors import ObservationError

F = TypeVar("F", bound=Callable[..., Any])


class Border:
    """A compiled function that Python calls through a check; for numba it is that function itself."""

    def __init__(self, compiled: Any, check: Callable[..., None]):
        self._compiled, self._check = compiled, check
        self.__doc__, self.__name__ = compiled.__doc__, compiled.__name__

    @property
    def _numba_type_(self) -> Any:
        return self._compiled._numba_type_

    def __call__(self, *arguments: Any) -> Any:
        """Check, then call."""
        self._check(*arguments)
        return self._compiled(*arguments)


def checked_by(check: Callable[..., None]) -> Callable[[F], F]:
    """Decorate a compiled function whose arguments ``check`` takes too, and refuses by an ``ObservationError``."""

    def border(compiled: F) -> F:
        return cast(F, Border(compiled, check))

    return border


def require_array(
    name: str, given: Any, shape: tuple[int, ...], kinds: str, lowest: Any = None, highest: Any = None
) -> None:
    """Hold an array against what compiled code takes.

    Args:
        name: What the message calls it.
        given: Should be an array.
        shape: Of the array; -1 stands for any length.
        kinds: Of its dtype, such as "iu".
        lowest: Least value that is allowed, or one for each place; None for any. With floats, NaN is never allowed.
        highest: The greatest, likewise.

    Raises:
        ObservationError: It is another thing.
    """
    if not isinstance(given, np.ndarray):
        raise ObservationError(f"{name}: expected an array {_sizes(shape)}; got {type(given).__name__}")
    fits = given.shape == shape or (  # the first is most calls, and takes a tenth of the time
        given.ndim == len(shape) and all(want in (-1, got) for want, got in zip(shape, given.shape, strict=True))
    )
    if not fits or given.dtype.kind not in kinds:
        raise ObservationError(
            f"{name}: expected {' or '.join(_KINDS[kind] for kind in kinds)} {_sizes(shape)}; "
            f"got {given.dtype} {given.shape}"
        )
    if lowest is not None and not ((given >= lowest) & (given <= highest)).all():
        raise ObservationError(f"{name}: expected values from {lowest} to {highest}; got {_shown(given)}")


def numbers(name: str, given: Any, shape: tuple[int, ...] | None = None) -> np.ndarray:
    """``given`` as an array of finite numbers; -1 in ``shape`` stands for any length, no shape for any.

    Args:
        name: Of the argument, for messages.
        given: What came.
        shape: Expected shape; -1 stands for any length. None: any shape.

    Raises:
        ObservationError: It is none, or has another shape.
    """
    try:
        array = np.asarray(given)
    except Exception as error:  # ragged lists, and whatever an object's own conversion raises
        raise ObservationError(f"{name}: expected numbers {_sizes(shape or ())}; got {type(given).__name__}") from error
    if np.ma.is_masked(given):
        raise ObservationError(f"{name}: expected numbers; got {_shown(given)}, of which values are masked")
    require_array(name, array, (-1,) * array.ndim if shape is None else shape, "iuf")
    if not np.isfinite(array).all():
        raise ObservationError(f"{name}: expected finite numbers; got {_shown(array)}")
    return array


_KINDS = {"b": "bool", "i": "int", "u": "unsigned int", "f": "float"}


def _sizes(shape: tuple[int, ...]) -> str:
    return str(shape).replace("-1", "any")


def _shown(given: np.ndarray) -> str:
    text = np.array2string(given, threshold=6, edgeitems=2)
    return " ".join(text.split())
