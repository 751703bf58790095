"""Options of all kinds: marks on config fields that the command line reads, and names that there are none of."""

from collections.abc import Iterable
from difflib import get_close_matches

import tyro

from jointattn_mj.errors import ConfigError

TOP_LEVEL = tyro.conf.arg(prefix_name=False)
"""An option that many use: `--caregiver`, not `--world.scene.caregiver`."""


def unknown(what: str, got: object, known: Iterable[str]) -> ConfigError:
    """The error for a name that there is none of: says what there is, and which of that may have been meant."""
    names = list(known)
    near = get_close_matches(str(got), names, n=1)
    perhaps = f"; perhaps you meant {near[0]}" if near else ""
    return ConfigError(f"no {what} {got!r}{perhaps}; there are: {', '.join(names)}")
