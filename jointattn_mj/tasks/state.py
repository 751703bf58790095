"""The saved state of an environment."""

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class EnvironmentState:
    """An environment at one moment, from ``Environment.get_state``; it can be copied and pickled.

    Attributes:
        built: How the environment was built, as far as its future depends on that.
        steps: Steps taken in this episode.
        over: Whether the next step starts another episode.
        task: Bodies, the caregiver's script, delayed images, and all random streams.
    """

    built: tuple[Any, ...]
    steps: int
    over: bool
    task: dict[str, Any]

    def __repr__(self) -> str:
        return f"EnvironmentState({self.built[0]}, step {self.steps}{', over' if self.over else ''})"
