"""Checks arguments of tasks by name and kind."""

from collections.abc import Iterable
from difflib import get_close_matches
from typing import Any

from jointattn_mj.errors import ConfigError
from jointattn_mj.options import shown


def unknown(what: str, got: object, known: Iterable[str]) -> ConfigError:
    """The error for an unknown name.

    Args:
        what: What kind of thing was named.
        got: The name that came.
        known: The names that there are; the nearest one is suggested.
    """
    names = list(known)
    near = get_close_matches(str(got), names, n=1)
    perhaps = f"; perhaps you meant {near[0]}" if near else ""
    return ConfigError(f"no {what} {shown(got)}{perhaps}; there are: {', '.join(names)}")


def require(name: str, given: Any, *kinds: type) -> None:
    """Check the kind of an argument.

    Raises:
        ConfigError: ``given``, the argument called ``name``, is of none of the ``kinds``.
    """
    if not isinstance(given, kinds):
        raise ConfigError(f"{name}: expected {' or '.join(kind.__name__ for kind in kinds)}; got {shown(given)}")
