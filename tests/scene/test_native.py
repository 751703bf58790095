"""Calls of the OpenGL libraries themselves."""

import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from jointattn_mj.scene.rendering import RenderingPhysics

pytestmark = pytest.mark.integration


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
