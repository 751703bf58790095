"""Objects that are searched for in a video, by colour."""

import re

import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.scene.objects import OBJECTS

KNOWN = {item.name: item.rgb for item in OBJECTS}


def object_colours(objects: tuple[str, ...]) -> tuple[tuple[str, ...], np.ndarray]:
    """Names and nominal colours (n, 3), 0..1, of objects.

    Args:
        objects: Names of known colours, or names of your own with a colour, ``cup=#c03a2b``.

    Raises:
        ConfigError: One is neither, or two have the same name.
    """
    names, colours = [], []
    for item in objects:
        name, given, code = item.partition("=")
        if given and not re.fullmatch(r"#?[0-9a-fA-F]{6}", code):
            raise ConfigError(f"objects: a colour is six hexadecimal digits, such as cup=#c03a2b; got {item!r}")
        if not given and name not in KNOWN:
            raise ConfigError(f"objects: give {', '.join(KNOWN)}, or a name and a colour, cup=#c03a2b; got {item!r}")
        if not name or name == "face" or name in names:
            raise ConfigError(f"objects: each needs a name of its own, and none is called face; got {item!r}")
        names.append(name)
        colours.append([value / 255 for value in bytes.fromhex(code.removeprefix("#"))] if given else KNOWN[name])
    if not names:
        raise ConfigError("objects: at least one is needed")
    return tuple(names), np.array(colours, float)
