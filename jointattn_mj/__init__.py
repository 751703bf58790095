"""A robot that learns to look where somebody else is looking, from rendered images, in MuJoCo.

The five jobs, each with a command of the same name:

    Session(...).run()            robot and caregiver interact; the robot learns to follow gaze    jointattn session
    Development(...).run()        a robot finds contingencies and makes behaviour of them          jointattn develop
    perceive(video)               what the robot would perceive in a video                         jointattn perceive
    read_recordings(files, ...)   coded interaction of people, for ``contingency``                 jointattn measure
    run_claim(id, out=...)        a claim of the dissertation, and what comes out here             jointattn experiment

``load(domain, task)`` gives a dm_control environment, and the module ``contingency`` the estimators.
"""

from importlib import import_module

from jointattn_mj.adapters import registration as _registration
from jointattn_mj.scene import gl as _gl
from jointattn_mj.scene import llvm as _llvm

TYPE_CHECKING = False  # as in typing, whose import takes long enough for a program to be interrupted in
if TYPE_CHECKING:
    from typing import Any

    from jointattn_mj import contingency, recordings
    from jointattn_mj.api.claim_result import ClaimResult
    from jointattn_mj.api.experiment import run_claim
    from jointattn_mj.api.perceive import perceive
    from jointattn_mj.api.session import Session
    from jointattn_mj.api.session_result import SessionResult
    from jointattn_mj.development.result import DevelopmentResult
    from jointattn_mj.development.run import Development
    from jointattn_mj.footage.frames import PerceivedFrame
    from jointattn_mj.footage.result import PerceptionResult
    from jointattn_mj.gaze_following.summary import SessionSummary
    from jointattn_mj.io.table import Table
    from jointattn_mj.recordings.reader import read_recordings
    from jointattn_mj.recordings.steps import Recordings
    from jointattn_mj.tasks import ALL_TASKS, BENCHMARKING, EASY, HARD, TASKS_BY_DOMAIN, load

_gl.choose_when_needed()
_llvm.keep_apart()
_registration.register_when_needed()

__version__ = "0.2.0.dev0"

__all__ = [
    "ALL_TASKS",
    "BENCHMARKING",
    "EASY",
    "HARD",
    "TASKS_BY_DOMAIN",
    "ClaimResult",
    "Development",
    "DevelopmentResult",
    "PerceivedFrame",
    "PerceptionResult",
    "Recordings",
    "Session",
    "SessionResult",
    "SessionSummary",
    "Table",
    "__version__",
    "contingency",
    "load",
    "perceive",
    "read_recordings",
    "recordings",
    "run_claim",
]

_HOMES = {
    "ALL_TASKS": "tasks",
    "BENCHMARKING": "tasks",
    "EASY": "tasks",
    "HARD": "tasks",
    "TASKS_BY_DOMAIN": "tasks",
    "load": "tasks",
    "Session": "api.session",
    "SessionResult": "api.session_result",
    "SessionSummary": "gaze_following.summary",
    "Development": "development.run",
    "DevelopmentResult": "development.result",
    "perceive": "api.perceive",
    "PerceivedFrame": "footage.frames",
    "PerceptionResult": "footage.result",
    "read_recordings": "recordings.reader",
    "Recordings": "recordings.steps",
    "run_claim": "api.experiment",
    "ClaimResult": "api.claim_result",
    "Table": "io.table",
}
"""The module of each public name; it is imported when the name is first asked for."""


def __getattr__(name: str) -> "Any":
    """A public name, whose module is imported now (PEP 562)."""
    if name in ("contingency", "recordings"):
        return import_module(f"jointattn_mj.{name}")
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = globals()[name] = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    return value


def __dir__() -> list[str]:
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})
