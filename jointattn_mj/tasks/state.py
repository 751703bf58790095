"""A whole environment at one moment, to go on from there any number of times."""

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class EnvironmentState:
    """What ``Environment.get_state`` gives: arrays and plain values, so that it can be copied and pickled.

    Attributes:
        built: How the environment was built, as far as its future depends on that.
        steps: Steps taken in this episode.
        over: Whether the next step begins another episode.
        task: Bodies, the caregiver's script, delayed images, and all random streams.
    """

    built: tuple[Any, ...]
    steps: int
    over: bool
    task: dict[str, Any]
