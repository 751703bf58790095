"""The robot's eye: a pinhole camera's geometry, and a renderer.

Pixels have x to the right and y down. A direction is a pair (pan, tilt), degrees, in the frame of the robot's base: the
head angles that bring a thing to the centre of view. Pan is positive to the robot's left, tilt upwards.
"""

from math import atan2, cos, degrees, hypot, radians, sin, tan
from typing import Any

import mujoco
import numpy as np
from dm_control.mujoco import Physics
from dm_control.mujoco.engine import Camera

from jointattn_mj.errors import GLError
from jointattn_mj.io.compiled import njit
from jointattn_mj.scene import gl, native
from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH

FOVY_DEG = 48.5
"""Vertical angle of view, degrees (6.4.1); at 4:3 the horizontal one is 61.9, as the text says."""
PIVOT = np.array([0.0, 0.0, 1.0])
"""Where pan axis, tilt axis and optical centre meet: (3,), world frame, metres."""
FOCAL_PX = IMAGE_HEIGHT / 2 / tan(radians(FOVY_DEG / 2))
CENTRE_X, CENTRE_Y = (IMAGE_WIDTH - 1) / 2, (IMAGE_HEIGHT - 1) / 2


def direction_of(pixel: np.ndarray, head: np.ndarray) -> np.ndarray:
    """Direction (2,), degrees, of what appears at ``pixel`` (2,) while the head is at ``head`` (2,), degrees."""
    left, up = (CENTRE_X - float(pixel[0])) / FOCAL_PX, (CENTRE_Y - float(pixel[1])) / FOCAL_PX
    pan, tilt = radians(head[0]), radians(head[1])
    ahead, z = cos(tilt) - sin(tilt) * up, sin(tilt) + cos(tilt) * up
    x, y = cos(pan) * ahead - sin(pan) * left, sin(pan) * ahead + cos(pan) * left
    return np.array([degrees(atan2(y, x)), degrees(atan2(z, hypot(x, y)))])


def pixel_of(direction: np.ndarray, head: np.ndarray) -> np.ndarray:
    """Pixel (2,) of what lies in ``direction`` (2,), with the head at ``head`` (2,); the inverse of direction_of."""
    pan, elevation, tilt = radians(direction[0] - head[0]), radians(direction[1]), radians(head[1])
    x, y, z = cos(elevation) * cos(pan), cos(elevation) * sin(pan), sin(elevation)
    depth, up = cos(tilt) * x + sin(tilt) * z, cos(tilt) * z - sin(tilt) * x
    return np.array([CENTRE_X - FOCAL_PX * y / depth, CENTRE_Y - FOCAL_PX * up / depth])


def off_centre(direction: np.ndarray, head: np.ndarray) -> float:
    """Angle, degrees, between a direction (2,) and the head's (2,), for angles small enough for the plane."""
    return hypot((direction[0] - head[0]) * cos(radians(head[1])), direction[1] - head[1])


def directions_to(points: np.ndarray) -> np.ndarray:
    """Directions (k, 2), degrees, of points (k, 3), world frame, metres."""
    x, y, z = (points - PIVOT).T
    directions: np.ndarray = np.degrees(np.stack([np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))], axis=1))
    return directions


def pixels_of_points(points: np.ndarray, head: np.ndarray) -> np.ndarray:
    """Pixels (k, 2) of points (k, 3), world frame, metres, while the head is at ``head`` (2,), degrees."""
    pan, tilt = radians(head[0]), radians(head[1])
    return _pixels(points, cos(pan), sin(pan), cos(tilt), sin(tilt))


def pixels_of_point(point: np.ndarray, heads: np.ndarray) -> np.ndarray:
    """Pixels (k, 2) of one point (3,), world frame, metres, for each of ``heads`` (k, 2), degrees.

    The numbers are those of ``pixels_of_points``, to the bit.
    """
    return _pixels(point[None], *_rotations(np.radians(heads.astype(float))))


@njit(cache=True)
def _rotations(angles: np.ndarray) -> np.ndarray:
    """Cosine and sine of pan, of tilt: (4, k), of angles (k, 2), rad. As ``math`` has them; numpy's are others.

    Compiled: .1 microseconds a row instead of .9.
    """
    rotations = np.empty((4, len(angles)))
    for k in range(len(angles)):
        rotations[0, k], rotations[1, k] = cos(angles[k, 0]), sin(angles[k, 0])
        rotations[2, k], rotations[3, k] = cos(angles[k, 1]), sin(angles[k, 1])
    return rotations


def _pixels(points: np.ndarray, cos_pan: Any, sin_pan: Any, cos_tilt: Any, sin_tilt: Any) -> np.ndarray:
    """Pixels (k, 2) of k points and one rotation of the head, or of one point and k rotations."""
    x, y, z = (points - PIVOT).T
    ahead = cos_pan * x + sin_pan * y
    depth, up = cos_tilt * ahead + sin_tilt * z, cos_tilt * z - sin_tilt * ahead
    left = cos_pan * y - sin_pan * x
    return np.stack([CENTRE_X - FOCAL_PX * left / depth, CENTRE_Y - FOCAL_PX * up / depth], axis=1)


def in_image(pixels: np.ndarray) -> np.ndarray:
    """Which pixels (k, 2) lie inside the image: (k,) bool."""
    inside = (pixels >= -0.5) & (pixels <= (IMAGE_WIDTH - 0.5, IMAGE_HEIGHT - 0.5))
    return inside[:, 0] & inside[:, 1]


class Eye:
    """Renders one camera of a physics into a buffer that is used again and again.

    OpenGL is opened at the first image, in the physics' own rendering context: dm_control's ``physics.render`` and
    wrappers work beside it. Only those calls of dm_control's ``Camera.render`` are made that a plain image needs, which
    saves 4 percent of the time.
    """

    def __init__(
        self, physics: Physics, camera: str = "robot/eye", width: int = IMAGE_WIDTH, height: int = IMAGE_HEIGHT
    ):
        """Prepare to render.

        Args:
            physics: Whose scene.
            camera: Name of a camera of the model.
            width: Of images, pixels.
            height: Of images, pixels.
        """
        self._physics, self._name, self._size = physics, camera, (height, width)
        self._camera: Camera | None = None
        self._rectangle = mujoco.MjrRect(0, 0, width, height)
        self._read = np.empty((height, width, 3), np.uint8)
        self._buffer = np.empty((height, width, 3), np.uint8)

    def render(self) -> np.ndarray:
        """Render the image now: uint8 (height, width, 3) RGB, which holds until the next call.

        Raises:
            GLError: No image can be rendered here; the message names the packages to install.
        """
        self._opened().update()
        self._draw_into(self._read, self._rectangle)
        np.copyto(self._buffer, self._read[::-1])  # OpenGL's first row is the lowest
        return self._buffer

    def _render_part(self, x0: int, y0: int, x1: int, y1: int) -> None:
        """Draw the pixels from x0, y0 to x1, y1 (exclusive) into the image."""
        camera = self._opened()
        camera.update()
        height, width = self._size
        for view in camera.scene.camera:  # of the left and the right eye, which are one
            top, tall = view.frustum_top, view.frustum_top - view.frustum_bottom
            left, wide = view.frustum_center - tall * width / height / 2, tall * width / height
            view.frustum_center = left + wide * (x0 + x1) / 2 / width
            view.frustum_top, view.frustum_bottom = top - tall * y0 / height, top - tall * y1 / height
        part = np.empty((y1 - y0, x1 - x0, 3), np.uint8)
        self._draw_into(part, mujoco.MjrRect(0, 0, x1 - x0, y1 - y0))
        self._buffer[y0:y1, x0:x1] = part[::-1]

    def forget(self) -> None:
        """Render the next image anew, whatever was rendered before; so does this eye in any case."""

    def get_state(self) -> dict[str, np.ndarray]:
        """What the next image depends on beside the physics: nothing."""
        return {}

    def set_state(self, state: dict[str, Any]) -> None:
        """Go on from a state."""

    def _draw_into(self, pixels: np.ndarray, rectangle: mujoco.MjrRect) -> None:
        """Draw the camera's scene into ``pixels`` (h, w, 3), the lowest row first."""
        contexts = self._physics.contexts
        with contexts.gl.make_current() as thread:
            thread.call(self._draw, pixels, rectangle, self._opened().scene.ptr, contexts.mujoco.ptr)

    @staticmethod
    def _draw(
        pixels: np.ndarray, rectangle: mujoco.MjrRect, scene: mujoco.MjvScene, context: mujoco.MjrContext
    ) -> None:
        mujoco.mjr_render(rectangle, scene, context)
        native.read_pixels(pixels, rectangle, context)

    def _opened(self) -> Camera:
        if self._camera is None:
            self._camera = self._open()
        return self._camera

    def _open(self) -> Camera:
        try:
            camera = Camera(self._physics, *self._size, camera_id=self._name)
            camera.render()
        except GLError:
            raise
        except Exception as error:  # PyOpenGL, mujoco and dm_control raise a dozen kinds here
            raise GLError(f"The OpenGL library could not open an offscreen image ({error}). {gl.INSTALL}") from error
        return camera
