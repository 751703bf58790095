"""Coded interaction of people: ``read`` opens files of events or steps, and the measures take the steps."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from jointattn_mj.recordings.events import Events
    from jointattn_mj.recordings.reader import Coding, ReadOptions, read
    from jointattn_mj.recordings.steps import Recordings

__all__ = ["Coding", "Events", "ReadOptions", "Recordings", "read"]

_HOMES = {"Coding": "reader", "Events": "events", "ReadOptions": "reader", "Recordings": "steps", "read": "reader"}


def __getattr__(name: str) -> Any:
    """A public name, whose module is imported now (PEP 562)."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
