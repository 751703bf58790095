"""MuJoCo's steps as functions of C, which compiled code can call without a call from Python for each."""

import ctypes
from functools import cache
from typing import Any

import mujoco

HALVES = ("mj_step1", "mj_step2")
_HOOKS = (mujoco.get_mjcb_control, mujoco.get_mjcb_passive)
"""The scene has no contacts, sensors or actuators of the kinds for which steps call others."""
_OF_C = (type(None), ctypes.CFUNCTYPE(None).__mro__[1])


@cache
def half_steps() -> tuple[Any, Any] | None:
    """MuJoCo's ``mj_step1`` and ``mj_step2``, which take addresses of model and data; None where they are not found."""
    try:
        library = ctypes.CDLL(mujoco._functions.__file__)  # finds what the module itself is linked with
        halves = tuple(getattr(library, name) for name in HALVES)
    except (AttributeError, OSError):
        return None
    for half in halves:
        half.argtypes, half.restype = [ctypes.c_void_p, ctypes.c_void_p], None
    return halves if hasattr(mujoco.MjModel, "_address") and hasattr(mujoco.MjData, "_address") else None


def calls_python() -> bool:
    """Whether MuJoCo's steps call functions of Python that somebody has set, as ``mujoco.set_mjcb_control`` does.

    What these raise gets through MuJoCo's binding alone; without it, the process ends.
    """
    return not all(isinstance(hook(), _OF_C) for hook in _HOOKS)
