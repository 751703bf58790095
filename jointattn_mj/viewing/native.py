"""A show in a window: MuJoCo's own viewer, with both lines of sight, and the robot's view in a corner."""

import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import cv2
import glfw
import mujoco
import mujoco.viewer
import numpy as np

from jointattn_mj.scene.model import ROBOT_GROUP
from jointattn_mj.video.onlooker import Sight
from jointattn_mj.video.paint import Colour
from jointattn_mj.viewing.eye import HEIGHT, WIDTH
from jointattn_mj.viewing.show import Show, in_real_time

AZIMUTH, ELEVATION, DISTANCE, LOOKS_AT = 76.0, -20.0, 2.3, (0.75, 0.0, 0.85)
"""Where the camera is at first, degrees and metres: robot and caregiver are in view."""
_LINE_M = 0.005
_CLOSES_S = 5.0  # seconds that a window may take to close


def has_display() -> bool:
    """Whether a window can be opened here."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # glfw warns where there is no display
        there = bool(glfw.init())
    glfw.terminate()
    return there


def show_in_window(show: Show, goes_on: Callable[[], bool]) -> None:
    """Show until the window is closed or ``goes_on`` says no. Another caregiver gets another window."""
    while goes_on():
        model, data = show.world.model, show.world.data
        with _window(model, data) as window:
            window.opt.geomgroup[ROBOT_GROUP] = 1
            window.cam.azimuth, window.cam.elevation, window.cam.distance = AZIMUTH, ELEVATION, DISTANCE
            window.cam.lookat[:] = LOOKS_AT

            def draw(window: mujoco.viewer.Handle = window) -> None:
                window.user_scn.ngeom = 0
                for sight, colour in show.sights():
                    _add_line(window.user_scn, sight, colour)
                window.set_images(_corner(show.eye(), window.viewport))
                words = show.words()
                window.set_texts((mujoco.mjtFont.mjFONT_NORMAL, mujoco.mjtGridPos.mjGRID_TOPLEFT, words, ""))
                window.sync()

            def same(window: mujoco.viewer.Handle = window, model: mujoco.MjModel = model) -> bool:
                return goes_on() and window.is_running() and show.world.model is model

            in_real_time(show, draw, same, lambda: False)
            if not window.is_running():
                return


@contextmanager
def _window(model: mujoco.MjModel, data: mujoco.MjData) -> Iterator[mujoco.viewer.Handle]:
    """A window that is gone with its thread at the end: MuJoCo would let that draw while Python ends."""
    before = set(threading.enumerate())
    window = mujoco.viewer.launch_passive(model, data, show_left_ui=False, show_right_ui=False)
    threads = set(threading.enumerate()) - before
    try:
        yield window
    finally:
        window.close()
        for thread in threads:
            thread.join(_CLOSES_S)


def _corner(eye: np.ndarray, window: mujoco.MjrRect | None) -> tuple[mujoco.MjrRect, np.ndarray]:
    """The robot's view (h, w, 3), two fifths as wide as the window, at its lower left."""
    width = WIDTH if window is None else max(80, min(WIDTH, 2 * window.width // 5))
    height = width * HEIGHT // WIDTH
    return mujoco.MjrRect(0, 0, width, height), cv2.resize(eye, (width, height), interpolation=cv2.INTER_AREA)


def _add_line(scene: mujoco.MjvScene, sight: Sight, colour: Colour) -> None:
    line = scene.geoms[scene.ngeom]
    scene.ngeom += 1
    rgba = np.array([*(np.array(colour) / 255), 0.8], np.float32)
    nothing, upright = np.zeros(3), np.eye(3).ravel()
    mujoco.mjv_initGeom(line, mujoco.mjtGeom.mjGEOM_CAPSULE, nothing, nothing, upright, rgba)
    mujoco.mjv_connector(line, mujoco.mjtGeom.mjGEOM_CAPSULE, _LINE_M, sight.start, sight.end)
