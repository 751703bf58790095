"""What is looked for in a video, and options that cannot work."""

from pathlib import Path

import numpy as np
import pytest

from jointattn_mj.errors import ConfigError
from jointattn_mj.footage.colours import object_colours
from jointattn_mj.footage.config import PerceiveConfig, PerceiveOptions
from jointattn_mj.scene.objects import OBJECTS


def test_colours():
    names, rgb = object_colours(("red", "cup=#C03A2b", "pen=0000ff"))
    assert names == ("red", "cup", "pen")
    np.testing.assert_allclose(rgb, [OBJECTS[0].rgb, np.array([192, 58, 43]) / 255, [0, 0, 1]])


@pytest.mark.parametrize(
    ("objects", "words"),
    [
        (("mauve",), "cup=#.*mauve"),
        (("yelow",), "perhaps you meant 'yellow'"),
        (("cup=red",), "hexadecimal.*cup=red"),
        (("cup=#fff",), "hexadecimal"),
        (("=#ff0000",), "name of its own"),
        (("face=#ff0000",), "none is called face"),
        (("red", "red=#00ff00"), "name of its own"),
        ((), "at least one"),
        (("cup=#808080",), "saturation"),
        (("cup=#ff0000", "mug=#ff0800"), "hues 8 deg apart"),
    ],
)
def test_colours_that_cannot_be_found(objects, words):
    with pytest.raises(ConfigError, match=words):
        PerceiveConfig(Path("a.mp4"), objects=objects)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("max_minutes", 0), ("max_minutes", float("nan")), ("fps", -1), ("fps", float("inf")), ("scale", 0),
        ("face_follow", 0), ("face_follow", 1.5), ("shift_frames", -1), ("seed", -1),
    ],
)  # fmt: skip
def test_bad_numbers(name, value):
    with pytest.raises(ConfigError, match=name):
        PerceiveConfig(Path("a.mp4"), **{name: value})


def test_bad_options():
    with pytest.raises(ConfigError, match="overlay_every"):
        PerceiveOptions(Path("out"), overlay_every=0)
