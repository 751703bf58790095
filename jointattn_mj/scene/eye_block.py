"""Memory that a process shares with an eye server: poses and parts of images that it wants drawn, and their pixels."""

import mmap
import os
from dataclasses import dataclass

import numpy as np

from jointattn_mj.io.compiled import njit
from jointattn_mj.scene.model import SceneConfig


@dataclass(frozen=True)
class EyeBlockLayout:
    """Sizes of the arrays in a block."""

    joints: int
    """Joint positions of a pose."""
    objects: int
    """Objects of a pose."""
    images: int
    """Most images that are asked for at once."""
    parts: int
    """Parts of an image."""
    pixels: int
    """Pixels of a part."""

    def arrays(self) -> dict[str, tuple[tuple[int, ...], type]]:
        """Shape and type of each array."""
        parts = self.images * self.parts
        return {
            "angles": ((self.images, self.joints), np.float32),
            "positions": ((self.images, self.objects, 3), np.float32),
            "corners": ((parts, 2), np.int32),
            "images": ((parts,), np.int32),
            "pixels": ((parts, self.pixels), np.uint32),
        }


@dataclass
class PartsRequest:
    """Parts of an image that are to be drawn."""

    scene: SceneConfig
    """What the world looks like."""
    angles: np.ndarray
    """(nq,) positions of all joints, radians."""
    positions: np.ndarray
    """(k, 3) positions of the objects, world frame, metres."""
    corners: np.ndarray
    """(n, 2) x and y of the parts' upper left pixels."""
    image: np.ndarray
    """(height, width, 3) uint8 RGB, in which the parts are put."""


class EyeBlock:
    """Arrays in a file of memory; requests are filled in by one process and answered by another.

    The file has no name, so that nothing is left of it when both have ended, however they end.

    Attributes:
        layout: Their sizes.
        angles: (m, nq) float32 joint positions of each image's pose, radians.
        positions: (m, k, 3) float32 positions of its objects, metres.
        corners: (n, 2) int32 corners of the parts, pixels.
        images: (n,) int32 number of the image that each part belongs to.
        pixels: (n, p) uint32 of each part, blue in the lowest byte, then green and red.
        number: Of the block among those of its client.
        file: Descriptor, to be closed when the other process has it; the memory stays.
        requests: What was added; ``filled``: the number of their parts.
    """

    angles: np.ndarray
    positions: np.ndarray
    corners: np.ndarray
    images: np.ndarray
    pixels: np.ndarray

    def __init__(self, layout: EyeBlockLayout, file: int | None = None, number: int = 0):
        """Make a block, or open that of another process.

        Args:
            layout: Sizes.
            file: Descriptor of another process's block.
            number: Of the block among those of its client.
        """
        self.layout, self.number = layout, number
        sizes = {name: (shape, np.dtype(kind)) for name, (shape, kind) in layout.arrays().items()}
        total = sum(int(np.prod(shape)) * kind.itemsize for shape, kind in sizes.values())
        self.file = os.memfd_create("jointattn-eye") if file is None else file
        os.ftruncate(self.file, total)
        memory = mmap.mmap(self.file, total)
        start = 0
        for name, (shape, kind) in sizes.items():
            count = int(np.prod(shape))
            setattr(self, name, np.frombuffer(memory, kind, count, start).reshape(shape))
            start += count * kind.itemsize
        self.requests: list[PartsRequest] = []
        self.filled = 0

    @property
    def full(self) -> bool:
        """Whether there is no room for another image."""
        return len(self.requests) == self.layout.images

    def add(self, request: PartsRequest) -> None:
        """Fill in another request; the block is not full."""
        number, first = len(self.requests), self.filled
        self.filled += len(request.corners)
        self.angles[number], self.positions[number] = request.angles, request.positions
        self.corners[first : self.filled], self.images[first : self.filled] = request.corners, number
        self.requests.append(request)

    def deliver(self, width: int) -> None:
        """Put the pixels that have come into the images that asked for them, and empty the block.

        Args:
            width: Of a part, pixels.
        """
        first = 0
        for request in self.requests:
            last = first + len(request.corners)
            _paste(self.pixels[first:last], self.corners[first:last], width, request.image)
            first = last
        self.requests, self.filled = [], 0


@njit(cache=True)
def _paste(pixels: np.ndarray, corners: np.ndarray, width: int, image: np.ndarray) -> None:
    """Put parts (n, h * width) of packed pixels at ``corners`` (n, 2) of an image (height, width, 3)."""
    for part in range(len(pixels)):
        left, top = corners[part]
        for k in range(pixels.shape[1]):
            packed, y, x = pixels[part, k], top + k // width, left + k % width
            image[y, x, 0], image[y, x, 1], image[y, x, 2] = packed >> 16 & 255, packed >> 8 & 255, packed & 255
