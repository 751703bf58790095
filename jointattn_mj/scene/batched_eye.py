"""An eye for many worlds at once: MuJoCo Warp casts the rays of all their images in one call, on a graphics card.

Images are those of ``Eye`` but for the outlines of things, fine shading, and round things, which are round here. Needs
the extra ``gpu``. OpenGL through EGL and Warp hang where they meet in one process: never render with both.
"""

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.guards.border import require_array
from jointattn_mj.io.extras import extra
from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH

TILES = ((8, 4),)
"""Thirty-two rays run in step on a card. Those of a tile meet the same things more often than those of a row: 31,200
images a second at 320x240 with 1,024 worlds on an H200, in place of 25,500."""
EYE_GROUPS = [0]
"""Groups of geoms that the robot's eye draws."""


class BatchedEye:
    """Draws the robot's image in many worlds.

    Nothing is simulated: a world's slot has no state but the pose that was put into it last, so that any slot can serve
    any world.

    Attributes:
        worlds: Number of slots.
        device: Warp's device.
    """

    _same_rays = True
    """Whether the rays of all slots leave the camera alike."""

    def __init__(
        self, model: mujoco.MjModel, worlds: int, width: int = IMAGE_WIDTH, height: int = IMAGE_HEIGHT,
        device: str | None = None, camera: str = "robot/eye", samples: int = 1,
        tiles: Sequence[tuple[int, int]] = TILES,
    ):  # fmt: skip
        """Prepare to draw; the first image compiles.

        Args:
            model: The compiled scene, of all worlds: poses differ, looks do not.
            worlds: Number of slots.
            width: Of images, pixels.
            height: Of images, pixels.
            device: Warp's name of the device, such as ``cuda:0`` or ``cpu``; None for the card, where there is one. The
                processor takes tens of milliseconds an image: for tests.
            camera: Name of a camera of the model.
            samples: Rays of a pixel along each side, averaged; one samples a point, and small images look ragged.
            tiles: Width and height, pixels, of tiles in which rays are cast, from small to large; none: row by row.
                Pixels are the same.

        Raises:
            ConfigError: A number is less than 1.
            ExtraError: The extra ``gpu`` is not installed.
        """
        numbers = {"worlds": worlds, "width": width, "height": height, "samples": samples}
        for name, number in numbers.items():
            if number < 1:
                raise ConfigError(f"`{name}` must be 1 or more; got {number}")
        self._warp, self._mjwarp = extra("gpu", "warp"), extra("gpu", "mujoco_warp")
        self.worlds, self.device = worlds, self._warp.get_device(device)
        self._pixels = pixel_order(width, height, tiles)
        self._shape = (worlds, height, width, 3)
        self._graph: Any = None
        with self._warp.ScopedDevice(self.device):
            self._model = self._mjwarp.put_model(model)
            self._data = self._mjwarp.make_data(model, nworld=worlds)
            self._context = self._mjwarp.create_render_context(
                model, nworld=worlds, cam_res=(width, height), cam_active=[camera], render_rgb=True, render_depth=False,
                render_seg=False, enabled_geom_groups=EYE_GROUPS, samples_per_pixel=samples,
                enable_specular=False, enable_emission=False,  # nothing in the scene shines
                use_precomputed_rays=self._same_rays,
            )  # fmt: skip
            rays = self._context.ray.numpy().reshape(samples * samples, -1, 3)
            self._context.ray.assign(rays[:, self._pixels].reshape(-1, 3))
            self._angles, self._objects, self._host = map(
                self._on_host, (self._data.qpos, self._data.mocap_pos, self._context.rgb_data)
            )

    def __repr__(self) -> str:
        worlds, height, width, _ = self._shape
        return f"BatchedEye({worlds} worlds, {width}x{height}, {self.device})"

    def _on_host(self, array: Any) -> Any:
        """Room on the host for an array of the device; from there a card reads at full speed."""
        return self._warp.zeros(array.shape, dtype=array.dtype, device="cpu", pinned=self.device.is_cuda)

    def set_poses(self, angles: np.ndarray, objects: np.ndarray) -> None:
        """Put a pose into each slot, as ``qpos`` and ``mocap_pos`` of a world's data have it.

        Args:
            angles: (worlds, nq) positions of all joints, radians.
            objects: (worlds, k, 3) positions of the objects, world frame, metres.

        Raises:
            ObservationError: They have other shapes.
        """
        kept = {"angles": (angles, self._angles.numpy()), "objects": (objects, self._objects.numpy())}
        for name, (given, own) in kept.items():
            require_array(name, given, own.shape, "f")
        for given, own in kept.values():
            own[:] = given

    def draw(self) -> None:
        """Draw the images of all slots. On a card this returns before they are drawn."""
        with self._warp.ScopedDevice(self.device):
            if self._graph is not None:
                self._warp.capture_launch(self._graph)
                return
            self.pose()
            self.refit()
            self.cast()

    def pose(self) -> None:
        """First part of ``draw``: take the poses to the device, and find where geoms, camera and lights are."""
        self._warp.copy(self._data.qpos, self._angles)
        self._warp.copy(self._data.mocap_pos, self._objects)
        self._mjwarp.kinematics(self._model, self._data)
        self._mjwarp.camlight(self._model, self._data)

    def refit(self) -> None:
        """Second part of ``draw``: fit the boxes in which rays look for geoms."""
        self._mjwarp.refit_bvh(self._model, self._data, self._context)

    def cast(self) -> None:
        """Third part of ``draw``: cast the rays."""
        self._mjwarp.render(self._model, self._data, self._context)

    def capture(self) -> None:
        """Let ``draw`` launch its kernels as one graph from now on, which pays with few worlds or small images.

        Raises:
            ConfigError: The device is no card.
        """
        if not self.device.is_cuda:
            raise ConfigError(f"a graph needs a graphics card; the device is {self.device}")
        self.draw()  # what is compiled at the first call cannot be captured
        with self._warp.ScopedDevice(self.device), self._warp.ScopedCapture() as kept:
            self.draw()
        self._graph = kept.graph

    def copy(self) -> None:
        """Begin to copy the images to the host."""
        self._warp.copy(self._host, self._context.rgb_data)

    def wait(self) -> None:
        """Wait until the device has done what it was given."""
        self._warp.synchronize_device(self.device)

    def images(self) -> np.ndarray:
        """The images that were drawn last, on the host: (worlds, height, width, 3) uint8 RGB, a new array."""
        self.copy()
        self.wait()
        packed = self._host.numpy().view(np.uint8).reshape(self.worlds, -1, 4)  # blue, green, red, opacity
        images = np.empty((self.worlds, packed.shape[1], 3), np.uint8)
        images[:, self._pixels] = packed[..., 2::-1]
        return images.reshape(self._shape)

    def tensor(self) -> Any:
        """The same images as a tensor of torch, which stays on the device."""
        torch = extra("gpu", "torch")
        packed = self._warp.to_torch(self._context.rgb_data).view(torch.uint8).reshape(self.worlds, -1, 4)
        where = torch.as_tensor(np.argsort(self._pixels), device=packed.device)
        return packed[:, where][..., [2, 1, 0]].reshape(self._shape)


def pixel_order(width: int, height: int, tiles: Sequence[tuple[int, int]]) -> np.ndarray:
    """Numbers (width * height,) of the pixels, row by row, in the order in which their rays are cast.

    Args:
        width: Of the image, pixels.
        height: Of the image.
        tiles: Width and height of tiles, from small to large, in which the order goes row by row; at the border they
            may be cut.
    """
    y, x = np.divmod(np.arange(width * height), width)
    keys = [x, y]
    for wide, high in tiles:
        keys += [x // wide, y // high]
    order: np.ndarray = np.lexsort(keys)
    return order
