"""Areas of known colours in many images at once, in torch: what ``ColourAreas`` finds in each, to the bit.

The images stay where they are, on a graphics card or not. Needs torch (the extra ``torch`` or ``gpu``).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from jointattn_mj.errors import ObservationError
from jointattn_mj.io.extras import extra
from jointattn_mj.perception.objects import CELL_BITS, STRIDE, Areas, ColourConfig, colour_table

RED, GREEN, BLUE, HALF, BITS = 9798, 19235, 3735, 1 << 14, 15
"""OpenCV's weights of a grey value, as ``gray.fill_gray`` has them."""
FAR = 1 << 20
"""Pixels; farther than any image reaches."""


def batched_gray(images: Any) -> Any:
    """Grey images (b, h, w) uint8 of a tensor of images (b, h, w, 3) uint8 RGB; those of OpenCV, to the bit."""
    torch = extra("torch", "torch")
    red, green, blue = images.to(torch.int32).unbind(-1)
    return ((RED * red + GREEN * green + BLUE * blue + HALF) >> BITS).to(torch.uint8)


@dataclass
class BatchedAreas:
    """The areas of n colours in b images, as tensors; see ``objects.Areas``, whose arrays these are, one an image."""

    visible: Any
    area: Any
    px: Any
    box: Any
    mask: Any
    corner: Any

    def of(self, image: int) -> Areas:
        """The areas in one image, as arrays on the host."""
        return Areas(**{name: values[image].cpu().numpy() for name, values in vars(self).items()})


class BatchedColourAreas:
    """Detects known colours in batches of images.

    Args:
        rgb: (n, 3) nominal colours of the objects, 0 to 1.
        config: Options.
        device: Torch's name of the device that the images are on.

    Raises:
        ConfigError: A colour is too pale or dark, or two are too alike.
    """

    def __init__(self, rgb: np.ndarray, config: ColourConfig | None = None, device: Any = "cpu"):
        self._torch = extra("torch", "torch")
        self.config = config or ColourConfig()
        self._table = self._torch.as_tensor(colour_table(rgb, self.config), device=device)
        self._colours = self._torch.arange(1, len(rgb) + 1, device=device).reshape(1, -1, 1, 1)

    def find(self, images: Any) -> BatchedAreas:
        """Detect the colours in a tensor of images (b, h, w, 3) uint8 RGB; h and w are multiples of 8.

        Raises:
            ObservationError: It is no such tensor.
        """
        torch = self._torch
        if (
            images.dtype != torch.uint8
            or images.ndim != 4
            or images.shape[3] != 3
            or any(side % (2 * STRIDE) or not side for side in images.shape[1:3])
        ):
            raise ObservationError(
                f"images: expected uint8 (b, h, w, 3) with h and w multiples of {2 * STRIDE}; got {images.dtype} "
                f"{tuple(images.shape)}"
            )
        red, green, blue = (images.to(torch.int32) >> 2).unbind(-1)
        labels = self._table[red << 12 | green << 6 | blue]  # (b, h, w)
        hits, x, y = self._read_coarsely(labels)
        most, centre = self._find_clusters(hits, x, y)
        return self._read_windows(labels, most, centre, self._surround(hits, x, y, centre))

    def _read_coarsely(self, labels: Any) -> tuple[Any, Any, Any]:
        """First pass: which colour has each pixel read, (b, n, h / 4, w / 4), and these pixels' x and y."""
        torch = self._torch
        count, height, width = labels.shape
        rows = labels[:, ::STRIDE].reshape(count, -1, 2, width)
        read = torch.stack([rows[:, :, 0, ::STRIDE], rows[:, :, 1, STRIDE // 2 :: STRIDE]], 2)
        y = STRIDE * torch.arange(height // STRIDE, device=labels.device)[:, None]
        x = STRIDE * torch.arange(width // STRIDE, device=labels.device) + y // STRIDE % 2 * (STRIDE // 2)
        return read.reshape(count, 1, *x.shape) == self._colours, x, y.expand_as(x)

    def _find_clusters(self, hits: Any, x: Any, y: Any) -> tuple[Any, Any]:
        """Hits (b, n) in each colour's fullest 2x2 cells, and their mean x and y, (b, n, 2)."""
        torch = self._torch
        side = (1 << CELL_BITS) // STRIDE
        values = torch.stack([hits, hits * x, hits * y], 2).to(torch.int64)  # (b, n, 3, rows, columns)
        down, right = (-size % side for size in x.shape)
        cells = torch.nn.functional.pad(values, (0, right, 0, down)).unflatten(-1, (-1, side)).sum(-1)
        cells = cells.unflatten(-2, (-1, side)).sum(-2)
        rows = cells[..., :-1, :] + cells[..., 1:, :]
        squares = (rows[..., :-1] + rows[..., 1:]).flatten(-2)
        fullest = squares[:, :, 0].argmax(-1)  # the first of equal ones
        sums = squares.gather(-1, fullest[..., None, None].expand(*fullest.shape, 3, 1))[..., 0]
        return sums[..., 0], sums[..., 1:] // sums[..., :1].clamp(min=1)

    def _surround(self, hits: Any, x: Any, y: Any, centre: Any) -> tuple[Any, Any]:
        """First and last pixel (b, n, 2), the last exclusive, of a box around the hits near each centre."""
        torch, reach = self._torch, self.config.reach_px
        cx, cy = centre[..., 0, None, None], centre[..., 1, None, None]
        near = hits & ((x - cx).abs() <= reach) & ((y - cy).abs() <= reach)
        low = [torch.where(near, at - STRIDE, FAR).flatten(-2).amin(-1) for at in (x, y)]
        high = [torch.where(near, at + STRIDE + 1, -FAR).flatten(-2).amax(-1) for at in (x, y)]
        first = torch.minimum(torch.stack(low, -1), centre)
        last = torch.maximum(torch.stack(high, -1), centre + 1)
        return torch.maximum(first, centre - reach), torch.minimum(last, centre + reach + 1)

    def _read_windows(self, labels: Any, most: Any, centre: Any, around: tuple[Any, Any]) -> BatchedAreas:
        """Second pass: the colours' own pixels around their clusters."""
        torch, reach = self._torch, self.config.reach_px
        count, height, width = labels.shape
        steps = torch.arange(-reach, reach + 1, device=labels.device)
        x, y = centre[..., 0, None] + steps, centre[..., 1, None] + steps  # (b, n, side)
        in_x = (x >= around[0][..., 0, None].clamp(min=0)) & (x < around[1][..., 0, None].clamp(max=width))
        in_y = (y >= around[0][..., 1, None].clamp(min=0)) & (y < around[1][..., 1, None].clamp(max=height))
        at = y.clamp(0, height - 1)[..., :, None] * width + x.clamp(0, width - 1)[..., None, :]
        own = labels.reshape(count, -1).gather(1, at.flatten(1)).reshape(at.shape) == self._colours
        mask = own & in_y[..., :, None] & in_x[..., None, :] & (most > 0)[..., None, None]
        columns, rows = mask.sum(-2), mask.sum(-1)  # pixels in each, (b, n, side)
        area = columns.sum(-1)
        visible = (area >= self.config.min_area_px) & (most > 0)
        sums = torch.stack([(columns * x).sum(-1), (rows * y).sum(-1)], -1).to(torch.float64)
        px = torch.where(visible[..., None], sums / area[..., None], torch.nan)
        low = [torch.where(there > 0, along, FAR).amin(-1) for there, along in ((columns, x), (rows, y))]
        high = [torch.where(there > 0, along + 1, -FAR).amax(-1) for there, along in ((columns, x), (rows, y))]
        box = torch.where(visible[..., None], torch.stack([*low, *high], -1), 0)
        corner = torch.where((most > 0)[..., None], centre - reach, 0)
        return BatchedAreas(visible, area.to(torch.int32), px, box.to(torch.int32), mask, corner.to(torch.int32))
