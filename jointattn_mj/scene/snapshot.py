"""Snapshots: the changing state of an object as plain data, which can be kept, copied, and put back many times.

A snapshot of an object is a dictionary of its attributes. Arrays are copied, random generators become the dictionary
that numpy gives of their state, objects become dictionaries in turn. What cannot change (numbers, text, frozen
dataclasses such as configs) stays itself.
"""

from collections import deque
from copy import deepcopy
from enum import Enum
from typing import Any

import numpy as np

from jointattn_mj.errors import StateError


def take(value: Any) -> Any:
    """Take a snapshot of ``value``; later changes of ``value`` do not change it."""
    if isinstance(value, np.ndarray):
        return value.copy()
    if value is None or isinstance(value, (int, float, str, Enum)) or _frozen(value):
        return value
    if isinstance(value, np.random.Generator):
        return value.bit_generator.state
    if isinstance(value, np.random.RandomState):
        return value.get_state(legacy=False)
    if isinstance(value, dict):
        return {name: take(item) for name, item in value.items()}
    if isinstance(value, (tuple, deque)):
        return tuple(map(take, value))
    if isinstance(value, list):
        return list(map(take, value))
    return {name: take(item) for name, item in vars(value).items()} if hasattr(value, "__dict__") else deepcopy(value)


def put(value: Any, snapshot: Any) -> Any:
    """Put a snapshot back.

    Args:
        value: What the snapshot was taken of, in its present state.
        snapshot: What ``take`` gave; it can be used again.

    Returns:
        ``value`` itself, restored, where it is an object; an equal value where it is not.

    Raises:
        StateError: An object of the snapshot does not exist any more.
    """
    if isinstance(value, np.random.Generator):
        value.bit_generator.state = snapshot
        return value
    if isinstance(value, np.random.RandomState):
        value.set_state(snapshot)
        return value
    if isinstance(value, deque):
        value.clear()
        value.extend(take(snapshot))
        return value
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return type(value)(*map(put, value, snapshot))
    if not isinstance(snapshot, dict):
        return take(snapshot)
    if isinstance(value, dict):
        return {name: put(value.get(name), item) for name, item in snapshot.items()}
    if not hasattr(value, "__dict__"):
        raise StateError(f"expected an object with {', '.join(snapshot)} to put a state back into; got {value!r}")
    attributes = vars(value)
    restored = {name: put(attributes.get(name), item) for name, item in snapshot.items()}
    attributes.clear()
    attributes.update(restored)
    return value


def _frozen(value: Any) -> bool:
    parameters = getattr(type(value), "__dataclass_params__", None)
    return parameters is not None and parameters.frozen
