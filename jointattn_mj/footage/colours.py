"""Objects that are searched for in a video: by a known colour, by a colour of one's own, or as picked in an image."""

import re
from dataclasses import dataclass

import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.options import meant
from jointattn_mj.scene.objects import OBJECTS

KNOWN = {item.name: item.rgb for item in OBJECTS}
_PICK = re.compile(r"(\d+(?:\.\d+)?)s:(\d+(?:\.\d+)?),(\d+(?:\.\d+)?)")


@dataclass(frozen=True)
class Sought:
    """One object that is searched for: by a colour, or as it looks at a spot of an image."""

    name: str
    rgb: tuple[float, float, float] | None
    """Nominal colour, 0..1."""
    picked: tuple[float, float, float] | None
    """Time in the video, s, and x, y, pixels of the video."""


def sought_objects(objects: tuple[str, ...]) -> tuple[Sought, ...]:
    """What is searched for.

    Args:
        objects: Names of known colours; names of your own with a colour, ``cup=#c03a2b``, or with the time and the
            pixel at which they are seen, ``cup@12.5s:420,310``.

    Raises:
        ConfigError: One is none of these, or two have the same name.
    """
    sought: list[Sought] = []
    for item in objects:
        wanted = _sought(item)
        if not wanted.name or wanted.name == "face" or wanted.name in [other.name for other in sought]:
            raise ConfigError(f"objects: each needs a name of its own, and none is called face; got {item!r}")
        sought.append(wanted)
    if not sought:
        raise ConfigError("objects: at least one is needed")
    return tuple(sought)


def _sought(item: str) -> Sought:
    if "@" in item:
        name, _, where = item.partition("@")
        pick = _PICK.fullmatch(where)
        if not pick:
            raise ConfigError(
                f"objects: one that is picked needs a time and a pixel of the video, cup@12.5s:420,310; got {item!r}"
            )
        seconds, x, y = map(float, pick.groups())
        return Sought(name, None, (seconds, x, y))
    name, given, code = item.partition("=")
    if given and not re.fullmatch(r"#?[0-9a-fA-F]{6}", code):
        raise ConfigError(f"objects: a colour is six hexadecimal digits, such as cup=#c03a2b; got {item!r}")
    if not given and name not in KNOWN:
        raise ConfigError(
            f"objects: give {', '.join(KNOWN)}, a name and a colour, cup=#c03a2b, or a name and where it is seen, "
            f"cup@12.5s:420,310; got {item!r}{meant(item, KNOWN)}"
        )
    if not given:
        return Sought(name, KNOWN[name], None)
    red, green, blue = (value / 255 for value in bytes.fromhex(code.removeprefix("#")))
    return Sought(name, (red, green, blue), None)


def candidate_names(objects: tuple[str, ...], areas: int = 1) -> tuple[str, ...]:
    """Names of the objects; where there may be several areas of each, ``cup``, ``cup_2`` and so on."""
    return tuple(
        item.name if k == 0 else f"{item.name}_{k + 1}" for item in sought_objects(objects) for k in range(areas)
    )


def object_colours(objects: tuple[str, ...]) -> tuple[tuple[str, ...], np.ndarray]:
    """Names and nominal colours (n, 3), 0..1, of the objects that are searched for by colour."""
    coloured = [(item.name, item.rgb) for item in sought_objects(objects) if item.rgb is not None]
    return tuple(name for name, _ in coloured), np.array([rgb for _, rgb in coloured], float).reshape(-1, 3)
