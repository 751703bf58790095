"""Calls of the OpenGL libraries themselves."""

import threading
from concurrent.futures import ThreadPoolExecutor

import mujoco
import numpy as np
import pytest
from dm_control.mujoco import engine

from jointattn_mj.scene import native
from jointattn_mj.scene.model import SceneConfig
from jointattn_mj.scene.rendering import RenderingPhysics
from jointattn_mj.scene.world import World, WorldConfig

pytestmark = pytest.mark.integration


@pytest.mark.parametrize("quality", ["high", "fast"])
@pytest.mark.parametrize(("width", "height"), [(320, 240), (48, 16), (31, 17), (1, 1)])
def test_pixels_are_those_that_mujoco_reads(quality, width, height):
    world = World.build(WorldConfig(scene=SceneConfig(quality=quality)), np.random.SeedSequence(0))
    camera = engine.Camera(world.physics, 240, 320, "robot/eye")
    camera.update()
    rectangle, contexts = mujoco.MjrRect(0, 0, width, height), world.physics.contexts
    own, theirs = np.zeros((2, height, width, 3), np.uint8)
    with contexts.gl.make_current():
        mujoco.mjr_render(rectangle, camera.scene.ptr, contexts.mujoco.ptr)
        native.read_pixels(own, rectangle, contexts.mujoco.ptr)
        mujoco.mjr_readPixels(theirs, None, rectangle, contexts.mujoco.ptr)
    np.testing.assert_array_equal(own, theirs)
    assert own.any()
    world.close()


def test_a_context_that_cannot_become_current_is_an_error():
    """As in a thread that asks for it while it is current in another: EGL refuses, and its error is raised."""
    physics = RenderingPhysics.from_xml_string("<mujoco/>")
    assert physics.render(24, 32).shape == (24, 32, 3)
    context = physics.contexts.gl

    def borrow():
        with context.make_current():
            pass

    with ThreadPoolExecutor(max_workers=1) as pool, context.make_current():
        context._render_executor._mutex = threading.RLock()  # which would have it wait
        with pytest.raises(Exception, match="EGL_BAD_ACCESS"):
            pool.submit(borrow).result(timeout=60)
    physics.free()
