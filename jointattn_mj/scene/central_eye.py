"""An eye that draws only the centre of its image, for an agent that senses only what is there."""

from math import ceil

import numpy as np
from dm_control.mujoco import Physics

from jointattn_mj.scene.camera import Eye
from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH
from jointattn_mj.scene.redrawing import TILE_PX


class CentralEye(Eye):
    """Images as large as those of the robot's eye, and black but for a part.

    Attributes:
        part: What is drawn: x0, y0, x1, y1 (the last two exclusive), pixels.
    """

    def __init__(self, physics: Physics, reach_px: float):
        """Prepare to render.

        Args:
            physics: Whose scene.
            reach_px: How far from the centre things are drawn, pixels; a little more is, up to the image's border.
        """
        super().__init__(physics)
        self._buffer[:] = 0
        half = np.array([IMAGE_WIDTH, IMAGE_HEIGHT]) // 2
        reach = np.minimum(half, ceil(reach_px / TILE_PX) * TILE_PX)
        self.part: tuple[int, ...] = *(half - reach).tolist(), *(half + reach).tolist()

    def render(self) -> np.ndarray:
        """See ``Eye.render``."""
        self._render_part(*self.part)
        return self._buffer
