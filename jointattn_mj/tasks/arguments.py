"""What a task is made with, checked by name and kind: one line says what was expected and what came."""

from collections.abc import Iterable
from difflib import get_close_matches
from typing import Any

from jointattn_mj.errors import ConfigError


def unknown(what: str, got: object, known: Iterable[str]) -> ConfigError:
    """The error for a name that there is none of: says what there is, and which of that may have been meant."""
    names = list(known)
    near = get_close_matches(str(got), names, n=1)
    perhaps = f"; perhaps you meant {near[0]}" if near else ""
    return ConfigError(f"no {what} {got!r}{perhaps}; there are: {', '.join(names)}")


def require(name: str, given: Any, *kinds: type) -> None:
    """Raises ConfigError: The argument ``name`` is of none of the ``kinds``."""
    if not isinstance(given, kinds):
        raise ConfigError(f"{name}: expected {' or '.join(kind.__name__ for kind in kinds)}; got {given!r}")
