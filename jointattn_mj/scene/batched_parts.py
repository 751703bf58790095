"""Parts of the images of many worlds, drawn at once: what has changed in an image is seldom all of it.

Every slot draws a rectangle of one size anywhere in the image of its pose. A pixel is the same whichever other parts
are drawn, as long as the corners of parts lie on one grid.
"""

import copy
from math import radians, tan

import mujoco
import numpy as np

from jointattn_mj.scene.batched_eye import BatchedEye
from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH

PART_WIDTH, PART_HEIGHT = 8, 48
"""Pixels; parts of 32x24 are as fast."""
NOWHERE = -(1 << 20)
"""Corner of a part in which nothing is to be seen, so that its rays cost next to nothing."""


class BatchedParts(BatchedEye):
    """Draws a part of the robot's image in each slot. See :class:`BatchedEye`; its images are the parts.

    Attributes:
        angles: (slots, nq) float32 positions of all joints, radians; written to before ``draw``.
        objects: (slots, k, 3) float32 positions of the objects, world frame, metres; likewise.
    """

    _same_rays = False

    def __init__(
        self, model: mujoco.MjModel, slots: int, part: tuple[int, int] = (PART_WIDTH, PART_HEIGHT),
        device: str | None = None, camera: str = "robot/eye", size: tuple[int, int] = (IMAGE_WIDTH, IMAGE_HEIGHT),
    ):  # fmt: skip
        """Prepare to draw; the first parts compile.

        Args:
            model: The compiled scene.
            slots: Number of parts that are drawn at once.
            part: Width and height of a part, pixels.
            device: Warp's name of the device, such as ``cuda:0`` or ``cpu``; None for the card, where there is one.
            camera: Name of a camera of the model.
            size: Width and height of the whole image, pixels.

        Raises:
            ConfigError: A number is less than 1.
            ExtraError: The extra ``gpu`` is not installed.
        """
        model, seen = copy.copy(model), model.camera(camera).id
        focal = size[1] / 2 / tan(radians(model.cam_fovy[seen]) / 2)
        model.cam_sensorsize[seen], model.cam_intrinsic[seen] = part, (focal, focal, 0, 0)  # in pixels
        super().__init__(model, slots, *part, device=device, camera=camera, tiles=())
        warp = self._warp
        self.angles, self.objects = self._angles.numpy(), self._objects.numpy()
        with warp.ScopedDevice(self.device):
            lenses = np.tile(model.cam_intrinsic.astype(np.float32), (slots, 1, 1))
            self._model.cam_intrinsic = warp.array(lenses, dtype=warp.vec4)
            self._lenses = self._on_host(self._model.cam_intrinsic)
        self._lenses.numpy()[:] = lenses
        self._centres = self._lenses.numpy()[:, seen, 2:]
        self._offset = (np.array(part) - size) / 2

    def set_corners(self, corners: np.ndarray) -> None:
        """Say which parts the first slots draw; the others draw nothing.

        Args:
            corners: (n, 2) x and y of the parts' upper left pixels in their images, n at most the number of slots.
        """
        self._centres[len(corners) :] = NOWHERE
        self._centres[: len(corners)] = corners + self._offset

    def pose(self) -> None:
        """First part of ``draw``; see :class:`BatchedEye`."""
        self._warp.copy(self._model.cam_intrinsic, self._lenses)
        super().pose()

    def packed(self) -> np.ndarray:
        """The pixels that were copied last: (slots, height * width) uint32, blue in the lowest byte, then green, red.

        They are there once ``wait`` has returned, and hold until the next ``copy``.
        """
        pixels: np.ndarray = self._host.numpy().reshape(self.worlds, -1)
        return pixels
