"""An eye that draws again only the part of its image in which something has moved, while it stands still itself.

In a session the head stands still in nine images of ten, and what moves in them lies in an eighth of the image or less
in half of the cases. A part is drawn through a part of the camera's frustum. It has the same pixels as the whole image
but for a few at the edges of things, by one grey value or two: parts begin and end on a grid, so that they are the same
ones each time.
"""

from collections.abc import Sequence
from math import radians, tan
from typing import Any

import mujoco
import numpy as np
from dm_control.mujoco import Physics
from dm_control.mujoco.engine import Camera

from jointattn_mj.guards.restored import check_array
from jointattn_mj.io.compiled import njit
from jointattn_mj.scene.camera import Eye
from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH

TILE_PX = 8
"""Parts of an image begin and end at multiples of this, pixels."""
STILL_RAD, STILL_M = 1e-5, 1e-6
"""What turns or moves by less since it was drawn stands still: less than a hundredth of a pixel."""
STEADY_RAD = 1e-4
"""The same for the camera, a thirtieth of a pixel: a head that has come to rest still turns by up to 9e-5."""
NEAR_M = 0.05
"""Things that reach nearer than this to the camera, metres, have no outline to reckon with: all is drawn."""
_HIDDEN, _BOUNDED, _ENDLESS = 0, 1, 2


class RedrawingEye(Eye):
    """Draws what has changed since its last image. Colours and lights must not: call ``forget`` after that."""

    def __init__(
        self,
        physics: Physics,
        camera: str = "robot/eye",
        width: int = IMAGE_WIDTH,
        height: int = IMAGE_HEIGHT,
        groups: Sequence[int] = (),
        apart: str | None = None,
    ):
        """Prepare to render.

        Args:
            physics: Whose scene.
            camera: Name of a camera of the model.
            width: Of images, pixels.
            height: Of images, pixels.
            groups: Groups of geoms that are drawn beside those that MuJoCo draws by itself.
            apart: Bodies whose names begin so have a part of the image for themselves, for they are far from the rest.
        """
        super().__init__(physics, camera, width, height)
        model, data = physics.model.ptr, physics.data.ptr
        number = model.camera(self._name).id
        self._focal = height / 2 / tan(radians(model.cam_fovy[number] / 2))
        self._eye, self._axes = data.cam_xpos[number], data.cam_xmat[number]  # views, like the next two
        self._positions, self._orientations = data.geom_xpos, data.geom_xmat
        self._bounds = model.geom_aabb  # a view: objects may change their sizes
        self._groups = mujoco.MjvOption().geomgroup.copy()
        self._groups[list(groups)] = 1
        visible = self._groups[model.geom_group].astype(bool) & (model.geom_rgba[:, 3] > 0)
        endless = model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE
        kinds = np.where(visible, np.where(endless, _ENDLESS, _BOUNDED), _HIDDEN)
        names = [model.body(body).name for body in model.geom_bodyid]
        far = np.array([apart is not None and name.startswith(apart) for name in names])
        self._parts = [np.where(part, kinds, _HIDDEN) for part in ([~far, far] if far.any() else [~far])]
        self._geoms = np.full((model.ngeom, 12), np.nan)  # position and orientation of each, as drawn
        self._stand = np.full(12, np.nan)  # the same of the camera
        self._box = np.zeros(4, np.int64)
        self._shadows = bool(model.light_castshadow.any())

    def render(self) -> np.ndarray:
        """Render the image now; see ``Eye.render``. What the caller changes in it would stay."""
        _ = self._physics.data  # a closed physics refuses; views do not
        if self._shadows:  # they change outside of what moves
            self.forget()
        try:
            self._redraw()
        except BaseException:  # what was to be drawn counts as drawn already
            self.forget()
            raise
        return self._buffer

    def _redraw(self) -> None:
        height, width = self._size
        for kinds in self._parts:
            whole = _find_changes(
                *self._poses(), self._bounds, kinds, self._eye, self._axes, self._geoms, self._stand, self._box,
                width, height, self._focal,
            )  # fmt: skip
            x0, y0, x1, y1 = self._box.tolist()
            if whole:
                self._render_all()
            elif x1 > x0:
                self._render_part(x0, y0, x1, y1)

    def _poses(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions (n, 3) and orientations (n, 9) of all that is drawn."""
        return self._positions, self._orientations

    def _open(self) -> Camera:
        camera = super()._open()
        camera.option.geomgroup[:] = self._groups
        return camera

    def _render_all(self) -> None:
        """Draw the whole image."""
        super().render()

    def forget(self) -> None:
        """Draw all of the next image."""
        self._stand[:] = np.nan

    def get_state(self) -> dict[str, np.ndarray]:
        """The last image and what stood where in it; later images do not change it."""
        return {"image": self._buffer.copy(), "geoms": self._geoms.copy(), "stand": self._stand.copy()}

    def set_state(self, state: dict[str, Any]) -> None:
        """Go on from a state; from one that holds nothing, with all of an image.

        Raises:
            ValueError: It is none of such an eye.
        """
        if not state:
            return self.forget()
        kept = {"image": self._buffer, "geoms": self._geoms, "stand": self._stand}
        for name, own in kept.items():
            check_array(f"the eye's {name}", state.get(name), own.shape, own.dtype)
            own[:] = state[name]


@njit(cache=True)
def _enclose(
    pose: np.ndarray, bounds: np.ndarray, eye: np.ndarray, axes: np.ndarray, box: np.ndarray, width: int, height: int,
    focal: float,
) -> bool:  # fmt: skip
    """Widen ``box`` so that it holds a geom's corners, and a pixel around them; for arguments see ``_find_changes``.

    Returns:
        Whether that can be reckoned: the geom does not reach the camera.
    """
    for corner in range(8):
        ahead = across = up = 0.0
        for k in range(3):
            at = pose[k] - eye[k]
            for j in range(3):
                at += pose[3 + 3 * k + j] * (bounds[j] + (bounds[3 + j] if corner >> j & 1 else -bounds[3 + j]))
            across, up, ahead = across + axes[3 * k] * at, up + axes[3 * k + 1] * at, ahead - axes[3 * k + 2] * at
        if not ahead > NEAR_M:
            return False
        x, y = width / 2 + focal * across / ahead, height / 2 - focal * up / ahead
        box[0], box[1] = min(box[0], max(0, int(x) - 1)), min(box[1], max(0, int(y) - 1))
        box[2], box[3] = max(box[2], min(width, int(x) + 2)), max(box[3], min(height, int(y) + 2))
    return True


@njit(cache=True)
def _find_changes(
    positions: np.ndarray, orientations: np.ndarray, bounds: np.ndarray, kinds: np.ndarray, eye: np.ndarray,
    axes: np.ndarray, drawn: np.ndarray, stand: np.ndarray, box: np.ndarray, width: int, height: int,
    focal: float,
) -> bool:  # fmt: skip
    """Find the part of the image in which something has moved, and take note of what will be drawn.

    Args:
        positions: (n, 3) of the geoms, world frame, metres.
        orientations: (n, 9) of the geoms, row by row.
        bounds: (n, 6) centre and half sides of a box around each, in its own frame, metres.
        kinds: (n,) whether each is hidden, bounded, or endless.
        eye: (3,) position of the camera.
        axes: (9,) its orientation: x to the right, y up, z backwards.
        drawn: (n, 12) position and orientation of each geom when it was last drawn; written to.
        stand: (12,) of the camera in the last whole image, likewise.
        box: (4,) x0, y0, x1, y1 of the part, the last two exclusive, pixels; written to.
        width: Of the image, pixels.
        height: Of the image.
        focal: Focal length, pixels.

    Returns:
        Whether all of the image is to be drawn.
    """
    whole = False
    for k in range(12):
        here, still = (eye[k], STILL_M) if k < 3 else (axes[k - 3], STEADY_RAD)
        whole |= not abs(here - stand[k]) <= still
    box[0], box[1], box[2], box[3] = width, height, 0, 0
    for i in range(len(positions)):
        if kinds[i] == _HIDDEN:
            continue
        moved = False
        for k in range(12):
            here, still = (positions[i, k], STILL_M) if k < 3 else (orientations[i, k - 3], STILL_RAD)
            moved |= not abs(here - drawn[i, k]) <= still
        if not moved:
            continue
        whole |= kinds[i] == _ENDLESS
        for now in range(2):  # where it was, and where it is
            if now:
                drawn[i, :3], drawn[i, 3:] = positions[i], orientations[i]
            whole |= not _enclose(drawn[i], bounds[i], eye, axes, box, width, height, focal)
    if whole:
        stand[:3], stand[3:] = eye, axes
        for i in range(len(positions)):
            drawn[i, :3], drawn[i, 3:] = positions[i], orientations[i]
    box[0], box[1] = box[0] // TILE_PX * TILE_PX, box[1] // TILE_PX * TILE_PX
    box[2], box[3] = min(width, -(-box[2] // TILE_PX) * TILE_PX), min(height, -(-box[3] // TILE_PX) * TILE_PX)
    return whole
