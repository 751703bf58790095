"""Object detection: each known colour's area in the image (sections 6.3.2 and 6.4.1).

A pixel belongs to a colour by its hue, if it is saturated and bright enough. Shading scales the three channels alike,
and so changes neither hue nor saturation. The rule is worked out once for a coarse cube of colours, then looked up.

An image is read in two passes. The first reads one pixel in sixteen and counts hits on a grid of cells; the fullest 2x2
cells are the colour's largest cluster. The second reads the surroundings of each cluster at full resolution, so that
stray pixels elsewhere (skin, hair, wood) do not shift the centre.
"""

import colorsys
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Protocol

import numpy as np
from numba import uintp

from jointattn_mj.errors import ConfigError
from jointattn_mj.guards.border import require_array
from jointattn_mj.guards.restored import check_array, check_whole
from jointattn_mj.io.compiled import njit
from jointattn_mj.io.opencv import cv2
from jointattn_mj.options import Checked, Real, Share, Whole
from jointattn_mj.perception.gray import fill_gray, require_gray, require_image

LEVEL_BITS = 6  # the look-up table has 2^6 levels a channel: 256 kB, and a level is 4 grey values wide
MOST_COLOURS = 254
CELL_BITS = 4  # cells of 16 x 16 pixels
STRIDE = 4  # the first pass reads every fourth pixel of every fourth row, from 0 and 2 in turn: no 2x8 area is missed


@dataclass(frozen=True)
class ColourConfig(Checked):
    """Options of the colour areas. The dissertation says "the color areas are extracted as object regions" (6.4.1)."""

    hue_tolerance_deg: Annotated[float, Real("[4, 180]")] = 20.0
    """Largest difference from the object's hue, degrees, and at most half the distance to the next object's hue."""
    saturation_ratio: Share = 0.72
    """Least saturation of a pixel, as a share of the object's; it keeps skin, hair and wood out."""
    value_floor: Annotated[float, Real("[0, 0.5]")] = 0.12
    """Least brightness of a pixel (HSV value, 0 to 1): below it eight-bit channels make hue coarse."""
    min_area_px: Annotated[int, Whole("[1, 76800]")] = 8
    """Least area of an object, pixels: with fewer it is hidden, or these are stray pixels."""
    reach_px: Annotated[int, Whole("[1, 320]")] = 22
    """Largest distance of an object's pixels from its cluster's centre: 6 cm at 0.9 m are 18 pixels, 26 diagonally."""

    ADVANCED: ClassVar = ("hue_tolerance_deg", "saturation_ratio", "value_floor", "min_area_px", "reach_px")


@dataclass
class Areas:
    """The areas of n colours in one image.

    Attributes:
        visible: (n,) bool, which were detected.
        area: (n,) pixels.
        px: (n, 2) centroid (x, y), pixels; NaN where not detected.
        box: (n, 4) x0, y0, x1, y1, the last two exclusive; zeros where not detected.
        mask: (n, m, m) bool, the object's own pixels in a window.
        corner: (n, 2) x, y of the window's upper left pixel, which may lie outside the image.
    """

    visible: np.ndarray
    area: np.ndarray
    px: np.ndarray
    box: np.ndarray
    mask: np.ndarray
    corner: np.ndarray

    def __repr__(self) -> str:
        return f"Areas({len(self.visible)} colours, visible={np.flatnonzero(self.visible).tolist()})"

    @classmethod
    def empty(cls, n: int, reach_px: int) -> "Areas":
        """Areas of ``n`` colours, none of them detected."""
        side = 2 * reach_px + 1
        return cls(
            np.zeros(n, bool), np.zeros(n, np.int32), np.full((n, 2), np.nan), np.zeros((n, 4), np.int32),
            np.zeros((n, side, side), bool), np.zeros((n, 2), np.int32),
        )  # fmt: skip


def check_areas(areas: Areas, model: Areas) -> None:
    """Check that areas from a checkpoint have the shapes and kinds of ``model``.

    Raises:
        ValueError: They have not.
    """
    for name, own in vars(model).items():
        check_array(f"the areas' {name}", getattr(areas, name), own.shape, own.dtype)


def colour_table(rgb: np.ndarray, config: ColourConfig) -> np.ndarray:
    """The label of each colour on a cube of 64 levels a channel.

    Args:
        rgb: (n, 3) nominal colours, 0..1.
        config: Options.

    Returns:
        (64^3,) uint8: 0 for no object, k + 1 for colour k, at index ``(r >> 2) << 12 | (g >> 2) << 6 | b >> 2``.

    Raises:
        ConfigError: A colour has too little saturation or brightness, or two have the same hue.
    """
    rgb = np.asarray(rgb, float)
    if rgb.ndim != 2 or rgb.shape[1] != 3 or not 1 <= len(rgb) <= MOST_COLOURS or not ((rgb >= 0) & (rgb <= 1)).all():
        raise ConfigError(f"object colours: expected (n, 3) numbers from 0 to 1; got {rgb.tolist()}")
    hsv = np.array([colorsys.rgb_to_hsv(*colour) for colour in rgb])
    hue, saturation, value = hsv[:, 0] * 360, hsv[:, 1], hsv[:, 2]
    if saturation.min() < 0.4 or value.min() < 2 * config.value_floor:
        raise ConfigError(
            f"object colours: expected saturation of .4 or more and a value of {2 * config.value_floor} or more "
            f"(a grey or dark thing has no hue to be told by); got {rgb.tolist()}"
        )
    between = np.abs((hue[:, None] - hue[None] + 180) % 360 - 180) + 360 * np.eye(len(hue))
    tolerance = np.minimum(config.hue_tolerance_deg, between.min(axis=1) / 2)
    if tolerance.min() < 4:
        raise ConfigError(f"object colours: expected hues 8 deg apart or more; got {np.round(hue).tolist()} deg")

    level = (np.arange(1 << LEVEL_BITS, dtype=np.float32) + 0.5) * (256 >> LEVEL_BITS) / 255
    red, green, blue = (axis.ravel() for axis in np.meshgrid(level, level, level, indexing="ij"))
    most = np.maximum(np.maximum(red, green), blue)
    spread = most - np.minimum(np.minimum(red, green), blue)
    with np.errstate(divide="ignore", invalid="ignore"):
        sixth = np.where(
            most == red,
            (green - blue) / spread % 6,
            np.where(most == green, (blue - red) / spread + 2, (red - green) / spread + 4),
        )
    cube_hue = np.where(spread > 0, sixth, 0) * 60
    off = np.abs((cube_hue[:, None] - hue[None] + 180) % 360 - 180)  # (64^3, n) deg
    nearest = off.argmin(axis=1)
    belongs = (
        (off[np.arange(len(off)), nearest] <= tolerance[nearest])
        & (spread / most >= config.saturation_ratio * saturation[nearest])
        & (most >= config.value_floor)
    )
    return np.where(belongs, nearest + 1, 0).astype(np.uint8)


@njit(cache=True)
def _label(channels: np.ndarray, table: np.ndarray, at: np.uintp) -> int:
    """Label of the pixel whose red is ``channels[at]``. Unsigned throughout: no wrap-around checks, half the time."""
    red, green, blue = uintp(channels[at]), uintp(channels[at + uintp(1)]), uintp(channels[at + uintp(2)])
    label: int = table[red >> uintp(2) << uintp(12) | green >> uintp(2) << uintp(6) | blue >> uintp(2)]
    return label


@njit(cache=True)
def _read_coarsely(image: np.ndarray, table: np.ndarray, hits: np.ndarray) -> int:
    """First pass: write (label - 1, x, y) of the pixels read that have a label. Returns their number."""
    height: int = image.shape[0]
    width: int = image.shape[1]
    channels, count = image.ravel(), 0
    for y in range(0, height, STRIDE):
        start = uintp(3 * y * width)
        for x in range(uintp(y // STRIDE % 2 * STRIDE // 2), uintp(width), uintp(STRIDE)):
            label = _label(channels, table, start + uintp(3) * x)
            if label:
                hits[count, 0], hits[count, 1], hits[count, 2] = label - 1, x, y
                count += 1
    return count


@njit(cache=True)
def _find_clusters(hits: np.ndarray, votes: np.ndarray, clusters: np.ndarray) -> None:
    """Write each label's fullest 2x2 cells to clusters (n, 3): hits, mean x, y. ``votes`` is working space."""
    votes[:] = 0
    for label, x, y in hits:
        vote = votes[label, y >> CELL_BITS, x >> CELL_BITS]
        vote[0] += 1
        vote[1] += x
        vote[2] += y
    n, rows, columns = votes.shape[0], votes.shape[1], votes.shape[2]
    for k in range(n):
        most = 0
        for i in range(rows - 1):
            for j in range(columns - 1):
                count = votes[k, i, j, 0] + votes[k, i, j + 1, 0] + votes[k, i + 1, j, 0] + votes[k, i + 1, j + 1, 0]
                if count > most:
                    most = count
                    for c in range(1, 3):
                        upper = votes[k, i, j, c] + votes[k, i, j + 1, c]
                        lower = votes[k, i + 1, j, c] + votes[k, i + 1, j + 1, c]
                        clusters[k, c] = (upper + lower) // count
        clusters[k, 0] = most


@njit(cache=True)
def _surround(hits: np.ndarray, k: int, cx: int, cy: int, reach: int, out: np.ndarray) -> None:
    """Write the box x0, y0, x1, y1 (the last two exclusive) of a label's hits within ``reach``, plus a stride."""
    out[0], out[1], out[2], out[3] = cx, cy, cx + 1, cy + 1
    for label, x, y in hits:
        if label == k and abs(x - cx) <= reach and abs(y - cy) <= reach:
            out[0], out[1] = min(out[0], x - STRIDE), min(out[1], y - STRIDE)
            out[2], out[3] = max(out[2], x + STRIDE + 1), max(out[3], y + STRIDE + 1)
    out[0], out[1] = max(out[0], cx - reach), max(out[1], cy - reach)
    out[2], out[3] = min(out[2], cx + reach + 1), min(out[3], cy + reach + 1)


@njit(cache=True)
def _find(
    image: np.ndarray, table: np.ndarray, hits: np.ndarray, votes: np.ndarray, clusters: np.ndarray, reach: int,
    min_area: int, gray: np.ndarray, visible: np.ndarray, area: np.ndarray, px: np.ndarray, box: np.ndarray,
    mask: np.ndarray, corner: np.ndarray,
) -> None:  # fmt: skip
    """Both passes: write area, centroid, box and mask of each label around its cluster, and ``gray`` there."""
    height, width = image.shape[0], image.shape[1]
    hits = hits[: _read_coarsely(image, table, hits)]
    _find_clusters(hits, votes, clusters)
    channels = image.ravel()
    around = np.empty(4, np.int64)
    for k in range(clusters.shape[0]):
        visible[k], area[k], px[k, :], box[k, :] = False, 0, np.nan, 0
        if clusters[k, 0] == 0:
            continue
        cx, cy = clusters[k, 1], clusters[k, 2]
        corner[k, 0], corner[k, 1] = cx - reach, cy - reach
        fill_gray(image, gray, cx - reach, cy - reach, cx + reach + 1, cy + reach + 1)
        _surround(hits, k, cx, cy, reach, around)
        mask[k] = False
        count, sum_x, sum_y = 0, 0, 0
        left, right, top, bottom = width, -1, height, -1
        x0, x1 = max(0, around[0]), min(width, around[2])
        for y in range(max(0, around[1]), min(height, around[3])):
            row, in_row = mask[k, y - cy + reach], 0
            at = uintp(3 * (y * width + x0))
            for x in range(x0, x1):
                own = _label(channels, table, at) == k + 1  # without branches, which could not be predicted
                row[uintp(x - cx + reach)] = own
                in_row += own
                sum_x += own * x
                left, right = min(left, x if own else width), max(right, x if own else -1)
                at += uintp(3)
            if in_row:
                count += in_row
                sum_y += y * in_row
                top, bottom = min(top, y), y
        area[k] = count
        if count >= min_area:
            visible[k] = True
            px[k, 0], px[k, 1] = sum_x / count, sum_y / count
            box[k, 0], box[k, 1], box[k, 2], box[k, 3] = left, top, right + 1, bottom + 1


class ObjectFinder(Protocol):
    """What an object detector offers."""

    def nothing(self) -> Areas:
        """Areas to be filled in by ``find``."""

    def find(self, image: np.ndarray, gray: np.ndarray, areas: Areas) -> None:
        """Detect the objects in an image; see ``ColourAreas.find``."""


class ColourAreas:
    """Detects known colours in images, each image by itself. It can be pickled."""

    def __init__(self, rgb: np.ndarray, config: ColourConfig | None = None):
        """Work out the table of colours.

        Args:
            rgb: (n, 3) nominal colours of the objects, 0 to 1.
            config: Options.

        Raises:
            ConfigError: A colour is too pale or dark, or two are too alike.
        """
        self.config = config or ColourConfig()
        self._table = colour_table(rgb, self.config)
        self._lay_out(len(rgb))

    def _lay_out(self, n: int) -> None:
        """Make working space for ``n`` colours."""
        self._clusters = np.zeros((n, 3), np.int32)
        self._shape = (0, 0, 3)  # of images that the next two are laid out for
        self._votes = np.zeros((n, 0, 0, 3), np.int32)
        self._hits = np.zeros((0, 3), np.int32)

    def __getstate__(self) -> dict[str, Any]:
        """All but working space."""
        return {"config": self.config, "_table": self._table, "colours": len(self._clusters)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a detector.

        Raises:
            ValueError: Compiled code could not look up its table.
        """
        self.config, self._table = state["config"], state["_table"]
        check_whole("colours", state["colours"], 1, MOST_COLOURS)
        check_array("table of colours", self._table, (1 << 3 * LEVEL_BITS,), np.uint8, 0, state["colours"])
        self._lay_out(state["colours"])

    def nothing(self) -> Areas:
        """Areas to be filled in by ``find``."""
        return Areas.empty(len(self._clusters), self.config.reach_px)

    def find(self, image: np.ndarray, gray: np.ndarray, areas: Areas) -> None:
        """Detect the colours in an image.

        Args:
            image: (h, w, 3) uint8 RGB, contiguous.
            gray: (h, w) uint8, contiguous; the grey image is written to it within the areas' windows.
            areas: What ``nothing`` gives; it is filled in.

        Raises:
            ObservationError: An argument is not such.
        """
        config = self.config
        require_image(image)
        require_gray(gray, image.shape[:2])
        side = 2 * config.reach_px + 1
        require_array("areas", areas.mask, (len(self._clusters), side, side), "b")
        if self._shape != image.shape:
            self._shape = height, width, _ = image.shape
            cell = 1 << CELL_BITS
            self._votes = np.zeros((len(areas.visible), -(-height // cell), -(-width // cell), 3), np.int32)
            self._hits = np.zeros((-(-height // STRIDE) * -(-width // STRIDE), 3), np.int32)
        _find(
            image, self._table, self._hits, self._votes, self._clusters, config.reach_px, config.min_area_px, gray,
            areas.visible, areas.area, areas.px, areas.box, areas.mask, areas.corner,
        )  # fmt: skip

    def segment(self, image: np.ndarray) -> tuple[np.ndarray, Areas]:
        """The grey image (h, w) uint8 and the colour areas of an RGB image (h, w, 3) uint8."""
        require_image(image)
        gray, areas = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), self.nothing()
        self.find(image, gray, areas)
        return gray, areas

    def labels(self, image: np.ndarray) -> np.ndarray:
        """Label of each pixel of an image (h, w, 3) uint8: (h, w) uint8, 0 for none. For overlays."""
        require_image(image)
        level = image.astype(np.int32) >> 2
        labels: np.ndarray = self._table[level[..., 0] << 12 | level[..., 1] << 6 | level[..., 2]]
        return labels
