"""Whether a restored run is built like a new one of the same config: attributes, kinds of values, shapes, names."""

from collections import deque
from enum import Enum
from typing import Any, get_args, get_type_hints

import numpy as np

from jointattn_mj.io.parts import is_part

_PLAIN = (str, int, float, Enum, type(None))


def check_fits(restored: Any, new: Any, name: str) -> None:
    """Refuse a restored object that is not built like a new one.

    Where the new one has None, or an empty list or dictionary, anything fits. None fits where the class says so in the
    annotation of the attribute. Numbers may differ; names and other tuples of plain values may not. Of classes that are
    not this package's own attributes are not compared.

    Args:
        restored: What a checkpoint gave.
        new: A new object of the same config.
        name: What it is called in the message.

    Raises:
        ValueError: Something differs; its path is in the message.
    """
    _Fitting().check(restored, new, name)


def check_attributes(restored: Any, new: Any, name: str) -> None:
    """Refuse an object that lacks an attribute of a new one.

    Args:
        restored: What a checkpoint gave.
        new: A new object of the same config.
        name: What it is called in the message.

    Raises:
        ValueError: It lacks one.
    """
    for attribute in getattr(new, "__dict__", {}):
        if attribute not in vars(restored):
            raise ValueError(f"{name} has no {attribute}")


class _Fitting:
    def __init__(self) -> None:
        self._checked = set[tuple[int, int]]()

    def check(self, restored: Any, new: Any, path: str) -> None:
        if new is None or (id(restored), id(new)) in self._checked:
            return
        self._checked.add((id(restored), id(new)))
        if isinstance(new, bool | int | float | np.number | np.bool_):
            if not _is_number(restored, new):
                raise ValueError(f"{path} must be of kind {type(new).__name__}; got {restored!r:.80}")
        elif type(restored) is not type(new):
            raise ValueError(f"{path} must be of kind {type(new).__name__}; got {type(restored).__name__}")
        elif isinstance(new, np.ndarray):
            if (restored.dtype, restored.shape) != (new.dtype, new.shape):
                came = f"{restored.shape} of {restored.dtype}"
                raise ValueError(f"{path} must be {new.shape} of {new.dtype}; got {came}")
        elif isinstance(new, tuple):
            self._check_tuple(restored, new, path)
        elif isinstance(new, dict):
            if new and restored.keys() != new.keys():
                raise ValueError(f"{path} has other keys")
            for key in new:
                self.check(restored[key], new[key], f"{path}[{key!r:.40}]")
        elif isinstance(new, list | deque):
            for number, item in enumerate(restored if new else ()):
                self.check(item, new[0], f"{path}[{number}]")
        elif is_part(type(new)):
            self._check_object(restored, new, path)

    def _check_tuple(self, restored: Any, new: Any, path: str) -> None:
        if type(new) is tuple and all(isinstance(item, _PLAIN) for item in new) and restored != new:
            raise ValueError(f"{path} must be {new!r:.80}; got {restored!r:.80}")
        if len(restored) != len(new):
            raise ValueError(f"{path} must have {len(new)} items; got {len(restored)}")
        for number, (part, new_part) in enumerate(zip(restored, new, strict=True)):
            self.check(part, new_part, f"{path}[{number}]")

    def _check_object(self, restored: Any, new: Any, path: str) -> None:
        check_attributes(restored, new, path)
        hints = get_type_hints(type(new)) if hasattr(new, "__dict__") else {}
        for name, value in getattr(new, "__dict__", {}).items():
            given = vars(restored)[name]
            if given is not None or type(None) not in get_args(hints.get(name)):
                self.check(given, value, f"{path}.{name}")


def _is_number(restored: Any, new: Any) -> bool:
    """Whether a number is of the kind of another one: truth values, whole numbers, or any numbers."""
    kinds: tuple[type, ...]
    if isinstance(new, bool | np.bool_):
        return isinstance(restored, bool | np.bool_)
    kinds = (int, np.integer) if isinstance(new, int | np.integer) else (int, float, np.integer, np.floating)
    return isinstance(restored, kinds) and not isinstance(restored, bool)
