"""Images of which only the centre is drawn."""

import numpy as np
import pytest

from jointattn_mj.scene.camera import Eye
from jointattn_mj.scene.central_eye import CentralEye
from jointattn_mj.scene.world import World, WorldConfig

pytestmark = pytest.mark.integration


@pytest.fixture(scope="module")
def world():
    made = World.build(WorldConfig(), np.random.SeedSequence(3))
    yield made
    made.close()


@pytest.mark.parametrize(("reach_px", "part"), [
    (40.1, (112, 72, 208, 168)), (48, (112, 72, 208, 168)), (130.0, (24, 0, 296, 240)), (1e4, (0, 0, 320, 240)),
])  # fmt: skip
def test_the_centre_is_that_of_the_whole_image(world, reach_px, part):
    whole, eye = Eye(world.physics), CentralEye(world.physics, reach_px)
    assert eye.part == part
    x0, y0, x1, y1 = part
    for _ in range(3):
        for _ in range(20):
            world.step(np.radians([10.0, -5.0]))
        image, expected = eye.render().astype(int), whole.render().astype(int)
        off = np.abs(image - expected).max(axis=2)[y0:y1, x0:x1] > 2
        assert off.mean() < 1e-3
        image[y0:y1, x0:x1] = 0
        assert not image.any()
