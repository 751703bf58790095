"""Objects as colour areas (sections 6.3.2 and 6.4.1): where each known colour is in the image, and the grey image.

A pixel belongs to a colour by its hue, if it is saturated and bright enough; shading scales the three channels alike
and so leaves hue and saturation alone. The rule is worked out once, for every colour on a coarse cube, and looked up
after.

One image is read in two passes. The first looks at one pixel in sixteen and counts hits on a grid of cells; the
fullest 2x2 cells tell where the colour's largest cluster is. The second reads what lies around each cluster at full
resolution, so a few stray pixels elsewhere (skin, hair, wood) do not bend the centre.
"""

import colorsys
from dataclasses import dataclass
from typing import Annotated, Any

import cv2
import numpy as np
from numba import uintp

from jointattn_mj.errors import ConfigError
from jointattn_mj.guards.border import require_array
from jointattn_mj.guards.restored import check_array, check_whole
from jointattn_mj.io.compiled import njit
from jointattn_mj.options import Checked, Real, Share, Whole
from jointattn_mj.perception.gray import fill_gray, require_gray, require_image

LEVEL_BITS = 6  # the look-up table has 2^6 levels a channel: 256 kB, and a level is 4 grey values wide
MOST_COLOURS = 254
CELL_BITS = 4  # cells of 16 x 16 pixels
STRIDE = 4  # the first pass reads every fourth pixel of every fourth row, by turns from 0 and 2: no 2x8 area slips by


@dataclass(frozen=True)
class ColourConfig(Checked):
    """Options of the colour areas. The dissertation says "the color areas are extracted as object regions" (6.4.1)."""

    hue_tolerance_deg: Annotated[float, Real("[4, 180]")] = 20.0
    """Widest hue difference that still counts; half the distance to the next object's hue where that is less."""
    saturation_ratio: Share = 0.72
    """A pixel has at least this share of the nominal saturation: keeps skin, hair and wood out."""
    value_floor: Annotated[float, Real("[0, 0.5]")] = 0.12
    """Darkest pixel (HSV value, 0..1) whose hue is trusted: below it eight-bit channels make hue coarse."""
    min_area_px: Annotated[int, Whole("[1, 76800]")] = 8
    """An area with fewer pixels is not an object: it is hidden, or stray pixels."""
    reach_px: Annotated[int, Whole("[1, 320]")] = 22
    """How far from its cluster's centre an object's pixels can lie: 6 cm at 0.9 m are 18 pixels, 26 over the corner."""


@dataclass
class Areas:
    """What was found of each of ``n`` colours in one image."""

    visible: np.ndarray  # (n,) bool
    area: np.ndarray  # (n,) pixels
    px: np.ndarray  # (n, 2) centroid (x, y); NaN when not seen
    box: np.ndarray  # (n, 4) x0, y0, x1, y1, the last two exclusive; zeros when not seen
    mask: np.ndarray  # (n, m, m) bool, the object's own pixels in a window whose upper left pixel is ``corner``
    corner: np.ndarray  # (n, 2) x, y of that pixel; it may lie outside the image

    @classmethod
    def empty(cls, n: int, reach_px: int) -> "Areas":
        """Nothing seen of ``n`` colours."""
        side = 2 * reach_px + 1
        return cls(
            np.zeros(n, bool), np.zeros(n, np.int32), np.full((n, 2), np.nan), np.zeros((n, 4), np.int32),
            np.zeros((n, side, side), bool), np.zeros((n, 2), np.int32),
        )  # fmt: skip


def check_areas(areas: Areas, model: Areas) -> None:
    """Refuse areas from a checkpoint that are not laid out as ``model``.

    Raises:
        ValueError: They are not.
    """
    for name, own in vars(model).items():
        check_array(f"the areas' {name}", getattr(areas, name), own.shape, own.dtype)


def colour_table(rgb: np.ndarray, config: ColourConfig) -> np.ndarray:
    """Label of every colour on a cube of 64 levels a channel.

    Args:
        rgb: (n, 3) nominal colours, 0..1.
        config: Options.

    Returns:
        (64^3,) uint8; 0 is no object, k+1 is colour k. Index ``(r >> 2) << 12 | (g >> 2) << 6 | b >> 2``.

    Raises:
        ConfigError: A colour has too little saturation or brightness, or two have the same hue.
    """
    rgb = np.asarray(rgb, float)
    if rgb.ndim != 2 or rgb.shape[1] != 3 or not 1 <= len(rgb) <= MOST_COLOURS or not ((rgb >= 0) & (rgb <= 1)).all():
        raise ConfigError(f"object colours: expected (n, 3) numbers from 0 to 1, came {rgb.tolist()}")
    hsv = np.array([colorsys.rgb_to_hsv(*colour) for colour in rgb])
    hue, saturation, value = hsv[:, 0] * 360, hsv[:, 1], hsv[:, 2]
    if saturation.min() < 0.4 or value.min() < 2 * config.value_floor:
        raise ConfigError(
            f"object colours: expected saturation of .4 or more and a value of {2 * config.value_floor} or more "
            f"(a grey or dark thing has no hue to be found by), came {rgb.tolist()}"
        )
    between = np.abs((hue[:, None] - hue[None] + 180) % 360 - 180) + 360 * np.eye(len(hue))
    tolerance = np.minimum(config.hue_tolerance_deg, between.min(axis=1) / 2)
    if tolerance.min() < 4:
        raise ConfigError(f"object colours: expected hues 8 deg apart or more, came {np.round(hue).tolist()} deg")

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
def _label(channels, table, at):
    """Label of the pixel whose red is ``channels[at]``. All unsigned: no wrap-around checks, half the time."""
    red, green, blue = uintp(channels[at]), uintp(channels[at + uintp(1)]), uintp(channels[at + uintp(2)])
    return table[red >> uintp(2) << uintp(12) | green >> uintp(2) << uintp(6) | blue >> uintp(2)]


@njit(cache=True)
def _read_coarsely(image, table, hits):
    """First pass: (label - 1, x, y) of the pixels looked at that have a label. Returns their number."""
    height, width = image.shape[0], image.shape[1]
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
def _find_clusters(hits, votes, clusters):
    """Each label's fullest 2x2 cells. votes: (n, gh, gw, 3) hits, sums of x and y; clusters: (n, 3) hits, mean x, y."""
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
def _surround(hits, k, cx, cy, reach, out):
    """The box x0, y0, x1, y1 (the last two exclusive) of a label's hits within ``reach``, and a stride around them."""
    out[0], out[1], out[2], out[3] = cx, cy, cx + 1, cy + 1
    for label, x, y in hits:
        if label == k and abs(x - cx) <= reach and abs(y - cy) <= reach:
            out[0], out[1] = min(out[0], x - STRIDE), min(out[1], y - STRIDE)
            out[2], out[3] = max(out[2], x + STRIDE + 1), max(out[3], y + STRIDE + 1)
    out[0], out[1] = max(out[0], cx - reach), max(out[1], cy - reach)
    out[2], out[3] = min(out[2], cx + reach + 1), min(out[3], cy + reach + 1)


@njit(cache=True)
def _find(image, table, hits, votes, clusters, reach, min_area, gray, visible, area, px, box, mask, corner):
    """Both passes: area, centroid, box and mask of each label within ``reach`` of its cluster, and ``gray`` there."""
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
                own = _label(channels, table, at) == k + 1  # without branches: their outcome is anybody's guess
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


class ColourAreas:
    """Finds known colours in images. Holds a table and buffers only: it can be pickled, and has no memory."""

    def __init__(self, rgb, config: ColourConfig | None = None):
        """``rgb``: (n, 3) nominal colours of the objects, 0..1, in the objects' order."""
        self.config = config or ColourConfig()
        self._table = colour_table(rgb, self.config)
        self._lay_out(len(rgb))

    def _lay_out(self, n: int) -> None:
        """Working space for ``n`` colours."""
        self._clusters = np.zeros((n, 3), np.int32)
        self._shape = (0, 0, 3)  # of images, for which these two are laid out
        self._votes = np.zeros((n, 0, 0, 3), np.int32)
        self._hits = np.zeros((0, 3), np.int32)

    def __getstate__(self) -> dict[str, Any]:
        """Without working space."""
        return {"config": self.config, "_table": self._table, "colours": len(self._clusters)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a finder. Raises ValueError: Its table is none that compiled code can look up."""
        self.config, self._table = state["config"], state["_table"]
        check_whole("colours", state["colours"], 1, MOST_COLOURS)
        check_array("table of colours", self._table, (1 << 3 * LEVEL_BITS,), np.uint8, 0, state["colours"])
        self._lay_out(state["colours"])

    def nothing(self) -> Areas:
        """Areas to be found by `find`."""
        return Areas.empty(len(self._clusters), self.config.reach_px)

    def find(self, image: np.ndarray, gray: np.ndarray, found: Areas) -> None:
        """Fill in the colour areas of an RGB image (h, w, 3) uint8, and ``gray`` (h, w) uint8 in their windows.

        A window is ``mask.shape`` pixels from ``corner``; image and ``gray`` are contiguous.

        Raises:
            ObservationError: Image or ``gray`` are not such, or ``found`` is not what ``nothing`` gives.
        """
        config = self.config
        require_image(image)
        require_gray(gray, image.shape[:2])
        side = 2 * config.reach_px + 1
        require_array("areas", found.mask, (len(self._clusters), side, side), "b")
        if self._shape != image.shape:
            self._shape = height, width, _ = image.shape
            cell = 1 << CELL_BITS
            self._votes = np.zeros((len(found.visible), -(-height // cell), -(-width // cell), 3), np.int32)
            self._hits = np.zeros((-(-height // STRIDE) * -(-width // STRIDE), 3), np.int32)
        _find(
            image, self._table, self._hits, self._votes, self._clusters, config.reach_px, config.min_area_px, gray,
            found.visible, found.area, found.px, found.box, found.mask, found.corner,
        )  # fmt: skip

    def segment(self, image: np.ndarray) -> tuple[np.ndarray, Areas]:
        """The whole grey image (h, w) uint8, and the colour areas, of an RGB image (h, w, 3) uint8."""
        require_image(image)
        gray, areas = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), self.nothing()
        self.find(image, gray, areas)
        return gray, areas

    def labels(self, image: np.ndarray) -> np.ndarray:
        """Label of every pixel, (h, w) uint8, 0 for none: for overlays and for looking into errors."""
        require_image(image)
        level = image.astype(np.int32) >> 2
        return self._table[level[..., 0] << 12 | level[..., 1] << 6 | level[..., 2]]
