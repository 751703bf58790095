"""A robot that learns to look where somebody else is looking, from rendered images, in MuJoCo."""

from typing import Any

from jointattn_mj.adapters import registration as _registration
from jointattn_mj.scene import gl as _gl
from jointattn_mj.scene import llvm as _llvm

_gl.choose_when_needed()
_llvm.keep_apart()
_registration.register_when_needed()

__version__ = "0.1.0"

_SUITE = ("load", "ALL_TASKS", "BENCHMARKING", "EASY", "HARD", "TASKS_BY_DOMAIN")


def __getattr__(name: str) -> Any:
    """What ``jointattn_mj.tasks`` offers, which imports mujoco when it is asked for."""
    if name in _SUITE:
        from jointattn_mj import tasks

        return getattr(tasks, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return [*globals(), *_SUITE]
