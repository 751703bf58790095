"""An eye whose images another process draws: what it asks for, and what it makes of the answer."""

from dataclasses import replace

import numpy as np
import pytest

from jointattn_mj.errors import ConfigError
from jointattn_mj.scene.batched_parts import PART_HEIGHT, PART_WIDTH
from jointattn_mj.scene.dressing import Conditions, Lamp
from jointattn_mj.scene.model import SceneConfig
from jointattn_mj.scene.warp_eye import WarpEye, parts_drawn_by
from jointattn_mj.scene.world import World, WorldConfig

PARTS = 320 // PART_WIDTH * (240 // PART_HEIGHT)


@pytest.fixture
def asked():
    """Sizes of the requests; parts are painted white."""
    sizes = []

    def paint(request):
        sizes.append(len(request.corners))
        for x, y in request.corners:
            assert x % PART_WIDTH == y % PART_HEIGHT == 0
            request.image[y : y + PART_HEIGHT, x : x + PART_WIDTH] = 255

    with parts_drawn_by(paint):
        yield sizes


def world(draws):
    return World.build(WorldConfig(renderer="warp", draws=draws), np.random.SeedSequence(3))


def test_asks_for_what_has_changed(asked):
    with_changes = world("changes")
    assert isinstance(with_changes.eye, WarpEye)
    assert (with_changes.image() == 255).all()
    assert asked == [PARTS]
    images = []
    for _ in range(40):
        with_changes.step(np.zeros(2))
        images.append(with_changes.image())
    assert max(asked[1:]) < PARTS
    assert len(asked) <= 41
    with_changes.step(np.array([0.5, 0]))
    with_changes.image()
    assert asked[-1] == PARTS
    with_changes.close()


def test_asks_for_all_where_all_is_drawn(asked):
    whole = world("all")
    for _ in range(3):
        whole.step(np.zeros(2))
        whole.image()
    assert asked == [PARTS] * 3
    whole.close()


def test_looks_stay_as_compiled(asked):
    made = world("changes")
    with pytest.raises(ConfigError, match="need opengl"):
        made.vary(made.config, Conditions(lamp=Lamp(azimuth_deg=5.0)))
    with pytest.raises(ConfigError, match="need opengl"):
        made.vary(replace(made.config, scene=SceneConfig(quality="high")), Conditions())
    made.close()
