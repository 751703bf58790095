"""What a checkpoint gives to compiled code, which takes types, shapes and places in memory on trust.

Classes whose arrays reach compiled code check them in ``__setstate__``, once, so that a file made up by somebody else
cannot make it read or write elsewhere.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike


def check_array(
    name: str,
    array: Any,
    shape: Sequence[int],
    dtype: DTypeLike,
    least: ArrayLike | None = None,
    most: ArrayLike | None = None,
) -> None:
    """Refuse an array that is not what it has to be.

    Args:
        name: What it is called in the message.
        array: As it was restored.
        shape: That it has to have.
        dtype: Likewise.
        least: Smallest values allowed, one or an array that broadcasts; NaN is allowed only without it.
        most: Largest ones.

    Raises:
        ValueError: It has another shape or dtype, or other values.
    """
    if type(array) is not np.ndarray or array.shape != tuple(shape) or array.dtype != np.dtype(dtype):
        came = f"{array.shape} of {array.dtype}" if isinstance(array, np.ndarray) else type(array).__name__
        raise ValueError(f"{name} must be {tuple(shape)} of {np.dtype(dtype)}; got {came}")
    if not array.flags.c_contiguous or not array.flags.aligned:
        raise ValueError(f"{name} must lie in memory row by row")
    if (least is not None and not (array >= least).all()) or (most is not None and not (array <= most).all()):
        raise ValueError(f"{name} holds values that it cannot have")


def check_whole(name: str, value: Any, least: int, most: int) -> None:
    """Refuse what is no whole number from ``least`` to ``most``.

    Args:
        name: Of the value, for messages.
        value: What a checkpoint held.
        least: Lowest that is allowed.
        most: Highest that is allowed.

    Raises:
        ValueError: It is none.
    """
    if type(value) is not int or not least <= value <= most:
        raise ValueError(f"{name} must be a whole number from {least} to {most}; got {value!r:.80}")


def check_alike(given: Any, model: Any, name: str = "") -> None:
    """Refuse a named tuple that is unlike ``model``: types, shapes, dtypes and plain numbers are compared.

    Args:
        given: What a checkpoint held.
        model: The same of a new run.
        name: Of the tuple, for messages.

    Raises:
        ValueError: Something differs; its name is in the message.
    """
    if type(given) is not type(model):
        raise ValueError(f"{name} must be of type {type(model).__name__}; got {type(given).__name__}")
    if isinstance(model, tuple):
        names = getattr(model, "_fields", range(len(model)))
        for field, part, model_part in zip(names, given, model, strict=True):
            check_alike(part, model_part, f"{name}.{field}" if name else str(field))
    elif isinstance(model, np.ndarray):
        check_array(name, given, model.shape, model.dtype)
    elif isinstance(model, bool | int | float) and given != model:
        raise ValueError(f"{name} must be {model}; got {given}")
