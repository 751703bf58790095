"""Calls of the OpenGL libraries themselves, where PyOpenGL or MuJoCo take longer than the library does."""

from collections.abc import Callable
from ctypes import CFUNCTYPE, c_int, c_uint, c_void_p
from functools import cache

import mujoco
import numpy as np
from dm_control import _render

from jointattn_mj.io.opencv import cv2

_RGBA, _UNSIGNED_BYTE = 0x1908, 0x1401


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


def read_pixels(pixels: np.ndarray, rectangle: mujoco.MjrRect, context: mujoco.MjrContext) -> None:
    """Read what ``mjr_render`` has drawn last.

    Mesa converts to three channels pixel by pixel. Reading four, of which OpenCV drops one, takes a quarter of the
    time: 60 microseconds less for an image of the robot's eye.

    Args:
        pixels: (h, w, 3) uint8 RGB, contiguous; written to, the lowest row first.
        rectangle: Where in the buffer it is, w wide and h high.
        context: In which it was drawn, offscreen.
    """
    if context.offSamples or _render.BACKEND != "egl":  # of several samples a pixel MuJoCo takes the mean
        mujoco.mjr_readPixels(pixels, None, rectangle, context)
        return
    height, width = pixels.shape[:2]
    rgba = np.empty((height, width, 4), np.uint8)
    _read_pixels()(rectangle.left, rectangle.bottom, width, height, _RGBA, _UNSIGNED_BYTE, rgba.ctypes.data)
    cv2.cvtColor(rgba, cv2.COLOR_RGBA2RGB, dst=pixels)


@cache
def _read_pixels() -> Callable[..., None]:
    from OpenGL.platform import PLATFORM

    return CFUNCTYPE(None, *[c_int] * 4, *[c_uint] * 2, c_void_p)(("glReadPixels", PLATFORM.GL))
