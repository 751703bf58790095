"""Calls of the OpenGL libraries themselves, where PyOpenGL takes longer than the library does."""

from collections.abc import Callable
from ctypes import CFUNCTYPE, c_uint, c_void_p
from functools import cache


def make_current(context: int | None) -> bool:
    """Make a context of EGL, at an address, current in this thread; or none.

    PyOpenGL asks for an error after each call: two calls take 40 microseconds an image instead of 9.

    Returns:
        Whether it is.
    """
    display, call = _make_current()
    return bool(call(display, None, None, context))


@cache
def _make_current() -> tuple[int, Callable[..., int]]:
    from dm_control._render.pyopengl.egl_renderer import EGL_DISPLAY
    from OpenGL.platform import PLATFORM

    return EGL_DISPLAY.address, CFUNCTYPE(c_uint, *[c_void_p] * 4)(("eglMakeCurrent", PLATFORM.EGL))
