"""The surface of a human head: skull, brows, sockets, lids, nose, lips, chin, ears and hair, as one generated mesh.

Head frame: origin between the ears (the centre of rotation), x out of the nose, y to the person's left, z up; metres.
The surface is a grid over azimuth (degrees, 0 at the nose, positive to the person's left) and height. Features of the
face are bumps in (y, z) of an average face; ``face_paint`` paints in the same coordinates. Rows follow the rims of the
eyelids: the eyes are openings behind which eyeballs turn.
"""

from __future__ import annotations

import numpy as np

from jointattn_mj.scene.people import FaceConfig
from jointattn_mj.scene.shapes import Mesh, bump, curve, grid, merge, refine, smoothstep, tube

EYE_Y, EYE_Z, EYE_RADIUS = 0.0315, 0.004, 0.0125  # centre and radius of an eyeball
EYE_HALF_WIDTH = 0.0155  # of the opening between the lids
TOP, BOTTOM = 0.123, -0.123  # heights (average face) between which the texture spans; textures wrap, so a little more
EYE_LEVEL_BREADTH = 0.073

# The mesh's lines on the average face, dense where the face has features: heights of rows above and below the eyes
# (whose own three rows are the lids' rims and what lies between), and columns of the left half, in front as y at eye
# level, then as azimuth. One set for figures and one as coarse as images of 320x240 allow.
EYE_ROWS = [0.0105, 0.004, -0.0025]
FINE_LINES = (
    [0.120, 0.116, 0.108, 0.096, 0.082, 0.068, 0.054, 0.042, 0.033, 0.026, 0.0185],
    [-0.0115, -0.019, -0.026, -0.031, -0.0355, -0.0395, -0.044, -0.0495, -0.0545, -0.0585, -0.063, -0.0675, -0.0725,
     -0.080, -0.089, -0.098, -0.107, -0.114, -0.120],
    [0, 0.0045, 0.009, 0.0135, 0.016, 0.0205, 0.026, 0.0315, 0.037, 0.0425, 0.047, 0.053, 0.060, 0.066],
    [73.0, 82, 91, 102, 115, 132, 155, 180],
)  # fmt: skip
COARSE_LINES = (
    [0.120, 0.113, 0.096, 0.074, 0.056, 0.036, 0.020],
    [-0.012, -0.023, -0.032, -0.0400, -0.0465, -0.0560, -0.0640, -0.0730, -0.086, -0.101, -0.113, -0.120],
    [0, 0.007, 0.0145, 0.0225, 0.0315, 0.0405, 0.048, 0.057, 0.066],
    [76.0, 92, 112, 145, 180],
)  # fmt: skip


def _lines(detail: int) -> tuple[list[float], list[float], list[float], list[float]]:
    return COARSE_LINES if detail == 1 else FINE_LINES


def half_breadth(config: FaceConfig, z: np.ndarray) -> np.ndarray:
    """Half the breadth of the head at height z of the average face."""
    jaw = 1 + (config.jaw - 1) * smoothstep(z, -0.02, -0.06)
    outline = curve(z, [
        (-0.120, 0.0), (-0.116, 0.020), (-0.105, 0.036), (-0.088, 0.047), (-0.066, 0.0565), (-0.040, 0.0645),
        (-0.015, 0.0705), (0.005, 0.0730), (0.035, 0.0755), (0.065, 0.0720), (0.090, 0.0590), (0.108, 0.0370),
        (0.116, 0.0200), (0.120, 0.0),
    ])  # fmt: skip
    breadth: np.ndarray = config.width * jaw * outline
    return breadth


def _front(z: np.ndarray) -> np.ndarray:
    return curve(z, [
        (-0.120, 0.050), (-0.116, 0.066), (-0.107, 0.0765), (-0.092, 0.0790), (-0.060, 0.0815), (-0.030, 0.0825),
        (0.005, 0.0840), (0.030, 0.0880), (0.055, 0.0850), (0.080, 0.0690), (0.102, 0.0420), (0.115, 0.0140),
        (0.120, -0.012),
    ])  # fmt: skip


def _back(z: np.ndarray) -> np.ndarray:
    return curve(z, [
        (-0.120, 0.050), (-0.112, 0.020), (-0.100, -0.010), (-0.080, -0.050), (-0.060, -0.074), (-0.020, -0.094),
        (0.030, -0.105), (0.065, -0.098), (0.092, -0.076), (0.110, -0.047), (0.117, -0.028), (0.120, -0.012),
    ])  # fmt: skip


def relief(config: FaceConfig, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """How far, metres, the features of the face stand out along x at (y, z) of the average face.

    Args:
        config: Shape of the face.
        y: Sideways, metres from the middle, of any shape.
        z: Height on the average face, metres, as many.
    """
    side = np.abs(y)
    nose_height = curve(z, [
        (-0.050, 0.0), (-0.0455, 0.002), (-0.041, 0.011), (-0.036, 0.0205), (-0.030, 0.0215), (-0.020, 0.017),
        (-0.006, 0.011), (0.008, 0.0065), (0.020, 0.004), (0.032, 0.0),
    ])  # fmt: skip
    nose_wide = config.nose_width * curve(z, [(-0.045, 0.0085), (-0.030, 0.0080), (-0.010, 0.0062), (0.020, 0.0075)])
    full = config.lip_fullness
    out: np.ndarray = (
        0.0045 * bump((z - 0.027) / 0.008, (side - 0.026) / 0.022)  # brow ridge
        - 0.0095 * bump((side - EYE_Y) / 0.014, (z - EYE_Z) / 0.011)  # sockets
        - 0.0030 * bump((side - 0.018) / 0.005, (z - 0.006) / 0.008)
        + config.nose * nose_height * bump(y / nose_wide)
        + 0.0075 * bump((side - 0.0125 * config.nose_width) / 0.0050, (z + 0.036) / 0.0060)  # wings of the nose
        + 0.0045 * bump((side - 0.044) / 0.017, (z + 0.018) / 0.016)  # cheeks
        - 0.0040 * bump((side - 0.050) / 0.016, (z + 0.062) / 0.020)
        + 0.0055 * bump(y / 0.026, (z + 0.062) / 0.018)  # mouth as a whole
        - 0.0012 * bump(y / 0.0030, (z + 0.050) / 0.0040)  # philtrum
        + full * 0.0042 * bump(y / 0.015, (z + 0.0575) / 0.0034)
        + full * 0.0050 * bump(y / 0.014, (z + 0.0690) / 0.0042)
        - 0.0030 * bump(y / 0.020, (z + 0.0630) / 0.0020)  # between the lips
        - 0.0035 * bump(y / 0.020, (z + 0.0800) / 0.0055)
        + 0.0065 * bump(y / 0.018, (z + 0.1000) / 0.0120)  # chin
    )
    return out


def lid_rims(config: FaceConfig, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Heights (average face) of the upper and the lower lid's rim at y; equal outside the opening."""
    s = (np.abs(y) - EYE_Y) / EYE_HALF_WIDTH
    opening = np.clip(1 - s * s, 0, 1)
    slant = 0.0010 * np.clip(s, -1.3, 1.3)  # the outer corner is a little higher
    middle = EYE_Z + slant
    return middle + 0.0052 * config.eye_size * opening**0.75, middle - 0.0044 * config.eye_size * opening**0.9


def hair_thickness(config: FaceConfig, azimuth: np.ndarray, z: np.ndarray) -> np.ndarray:
    """0 on skin, 1 well inside the hair; azimuth in degrees, z on the average face.

    Args:
        config: Shape of the face and its hair.
        azimuth: Degrees from the front, of any shape.
        z: Height on the average face, metres, as many.
    """
    side = np.abs(azimuth)
    front = {"short": 0.066, "bob": 0.062, "bun": 0.068, "curly": 0.070, "receding": 0.082}[config.hair_style]
    receding = 0.014 if config.hair_style == "receding" else 0.0
    line = curve(side, [
        (0, front), (22, front + 0.003 + receding), (42, front - 0.004 + receding), (56, front - 0.022),
        (64, 0.020), (70, 0.000), (77, -0.016), (83, -0.012), (90, 0.026), (104, 0.026), (112, -0.030),
        (124, -0.066), (180, -0.080),
    ])  # fmt: skip
    return smoothstep(z - line, -0.002, 0.006)


def _hair_depth(config: FaceConfig, azimuth: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Thickness (m) of the hair over the scalp."""
    body = {"short": 0.009, "bob": 0.012, "bun": 0.008, "curly": 0.024, "receding": 0.005}[config.hair_style]
    inside = hair_thickness(config, azimuth, z)
    side = np.abs(azimuth)
    depth = body * (0.5 + 0.5 * smoothstep(z, 0.02, 0.09))
    if config.hair_style == "curly":
        rng = np.random.default_rng(config.seed)
        phase = rng.uniform(0, 2 * np.pi, 4)
        wave = sum(
            np.sin(np.radians(azimuth) * k + z * f + p)
            for k, f, p in zip((5, 9, 7, 12), (90, -140, 210, 60), phase, strict=True)
        )
        depth = depth * (0.50 + 0.50 * smoothstep(side, 30, 90)) + 0.0016 * wave
    thickness: np.ndarray = inside * depth
    return thickness


def surface(config: FaceConfig, azimuth: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Points (..., 3), metres, of skin or hair at azimuth, degrees, and height z of the average face; without eyes.

    Args:
        config: Shape of the face and its hair.
        azimuth: Degrees from the front, of any shape.
        z: Height on the average face, metres, as many.
    """
    a = np.radians(azimuth)
    breadth, front, back = half_breadth(config, z), _front(z), _back(z)
    middle = np.maximum(np.minimum(0.0, front - 0.01), back)  # where front and back halves meet
    middle = np.where(back > middle, back, middle)
    y = breadth * np.sin(a)
    ahead = np.cos(a) >= 0
    bend = np.clip(1 - np.abs(np.sin(a)) ** np.where(ahead, 2.35, 2.15), 0, 1) ** np.where(ahead, 1 / 2.35, 1 / 2.15)
    x = np.where(ahead, middle + (front - middle) * bend, middle + (back - middle) * bend)
    x = x + relief(config, y, z) * smoothstep(np.cos(a), 0.05, 0.45)
    out = np.stack([x, y, np.where(z < EYE_Z, EYE_Z + (z - EYE_Z) * config.length, z)], -1)
    level = np.clip(breadth / (config.width * EYE_LEVEL_BREADTH), 0, 1)  # 0 at the crown
    normal = np.stack([np.cos(a) * level, np.sin(a) * level, 1.6 * smoothstep(z, 0.03, 0.12)], -1)
    normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-9)
    points: np.ndarray = out + normal * _hair_depth(config, azimuth, z)[..., None]
    return points


def _columns(detail: int) -> np.ndarray:
    """Azimuths (deg) of the columns from -180 to 180."""
    _, _, front, side = _lines(detail)
    left = np.concatenate([np.degrees(np.arcsin(np.array(front) / EYE_LEVEL_BREADTH)), side])
    return refine(np.concatenate([-left[:0:-1], left]), max(1, detail - 1))


def _rows(config: FaceConfig, azimuth: np.ndarray, detail: int) -> tuple[np.ndarray, np.ndarray]:
    """Heights (rows, columns) on the average face, and which of these points lie behind the opening of the lids."""
    above, below, _, _ = _lines(detail)
    factor = max(1, detail - 1)
    z = np.repeat(np.array(above + EYE_ROWS + below)[:, None], len(azimuth), axis=1)
    first = len(above)
    y = half_breadth(config, np.array(EYE_Z)) * np.sin(np.radians(azimuth))
    s = (np.abs(y) - EYE_Y) / EYE_HALF_WIDTH
    ahead = np.cos(np.radians(azimuth)) > 0
    near = np.where(ahead, 1 - smoothstep(np.abs(s), 1.05, 2.1), 0)
    upper, lower = lid_rims(config, y)
    for row, rim in ((first, upper + 0.0006), (first + 1, (upper + lower) / 2), (first + 2, lower - 0.0006)):
        z[row] += near * (rim - z[row])
    z = np.stack([refine(z[:, k], factor) for k in range(len(azimuth))], axis=1)
    level = np.arange(len(z))[:, None] / factor
    behind = (level > first) & (level < first + 2) & (np.abs(s) < 0.97)[None] & ahead[None]
    return z, behind


def texture_coordinates(azimuth: np.ndarray, z: np.ndarray) -> np.ndarray:
    """(..., 2): u over azimuth, the front half taking most of it; v over height."""
    return np.stack(
        [0.5 + 0.5 * np.sign(azimuth) * np.interp(np.abs(azimuth), *_UNROLL), (z - BOTTOM) / (TOP - BOTTOM)], -1
    )


def texture_azimuth(u: np.ndarray) -> np.ndarray:
    """The azimuth (deg) painted at u: inverse of ``texture_coordinates``."""
    azimuth: np.ndarray = np.sign(u - 0.5) * np.interp(np.abs(2 * u - 1), _UNROLL[1], _UNROLL[0])
    return azimuth


_UNROLL = ([0.0, 75.0, 110.0, 180.0], [0.0, 0.72, 0.86, 1.0])


def eye_depth(config: FaceConfig) -> float:
    """x, metres, of the eyeballs' centres: so deep that they fill the sockets."""
    azimuth = np.degrees(np.arcsin(EYE_Y / half_breadth(config, np.array(EYE_Z))))
    return float(surface(config, azimuth, np.array(EYE_Z))[0]) + 0.0035 - EYE_RADIUS


def _skull(config: FaceConfig, detail: int) -> Mesh:
    azimuth = _columns(detail)
    z, behind = _rows(config, azimuth, detail)
    azimuth = np.broadcast_to(azimuth, z.shape)
    points = surface(config, azimuth, z)
    across = (np.abs(points[..., 1]) - EYE_Y) ** 2 + (points[..., 2] - EYE_Z) ** 2
    ball = eye_depth(config) + np.sqrt(np.maximum((EYE_RADIUS + 0.0011) ** 2 - across, 0))
    lids = (across < EYE_RADIUS**2) & (points[..., 0] > 0)
    points[..., 0] = np.where(lids, np.maximum(points[..., 0], ball), points[..., 0])
    points[..., 0] = np.where(behind, eye_depth(config) - 0.002, points[..., 0])
    return grid(points, texture_coordinates(azimuth, z))


def _ear(config: FaceConfig, side: int, segments: int) -> Mesh:
    """An ear, a shallow dish that stands off the head at its rear; ``side`` 1 is the left, -1 the right."""
    radius = np.array([0.0, 0.55, 0.9, 1.0, 0.92])[:, None]
    off = np.array([0.004, 0.005, 0.010, 0.008, -0.004])[:, None]
    angle = np.linspace(0, 2 * np.pi, segments + 1)[None]
    lobe = 1 - 0.25 * smoothstep(-np.cos(angle), 0.2, 1.0)
    x = 0.0165 * radius * np.sin(angle) * lobe * side
    z = 0.031 * radius * np.cos(angle)
    y = half_breadth(config, np.array(0.0)) + off - 0.45 * x
    points = np.stack([x - 0.012, side * y, z - 0.004], -1)
    uv = texture_coordinates(np.full(x.shape, side * 68.0) - 90 * (x + 0.0), -0.024 + 0.15 * z)
    return grid(points, uv)


def _curtain(factor: int) -> Mesh:
    """Hair of chin length around sides and back: outside from top to tips, inside up again."""
    azimuth = refine(np.array([58, 64, 74, 86, 100, 120, 145, 180, 215, 240, 260, 274, 286, 296, 302.0]), factor)
    z = refine(np.array([0.080, 0.060, 0.030, -0.010, -0.050, -0.085, -0.103, -0.095, -0.050, 0.0]), factor)
    outward = refine(np.array([-0.006, 0.004, 0.009, 0.012, 0.013, 0.011, 0.003, -0.003, -0.002, 0.0]), factor)
    edge = smoothstep(np.abs(azimuth - 180), 122, 112)[None]  # front edges: outside and inside meet
    outward = 0.004 + edge * (outward[:, None] - 0.004)
    a, level = np.radians(azimuth)[None], np.maximum(z, -0.012)[:, None]
    wide = curve(level, [(-0.012, 0.074), (0.035, 0.0755), (0.065, 0.0720), (0.090, 0.0590)]) + outward
    back = curve(level, [(-0.012, 0.098), (0.030, 0.105), (0.065, 0.098), (0.092, 0.076)]) + outward
    x = np.where(np.cos(a) > 0, 0.075, back) * np.cos(a)
    points = np.stack([x, wide * np.sin(a), np.broadcast_to(z[:, None], x.shape)], -1)
    u = 178 - 0.42 * np.abs(azimuth - 180)  # mirrored: no seam at the back, and nothing but hair
    uv = texture_coordinates(
        np.broadcast_to(u[None], x.shape), np.interp(z, [-0.11, 0.08], [-0.02, 0.09])[:, None] + 0 * x
    )
    return grid(points, uv)


def _bun(sides: int) -> Mesh:
    x = np.array([-0.075, -0.080, -0.095, -0.115, -0.132, -0.139, -0.141])
    radius = np.array([0.020, 0.030, 0.038, 0.038, 0.026, 0.013, 0.0])
    centres = np.stack([x, 0 * x, 0.055 - 0.15 * (x + 0.075)], -1)
    left, low = texture_coordinates(np.array(128.0), np.array(0.0))
    right, high = texture_coordinates(np.array(176.0), np.array(0.08))
    return tube(centres, np.stack([radius, radius], -1), sides, (0, 0, 1), (left, low, right, high))


def head(config: FaceConfig, detail: int) -> Mesh:
    """The head without eyeballs; ``detail`` 1 for images of 320x240, 2 or 3 for figures."""
    parts = [_skull(config, detail)]
    if config.hair_style == "bob":
        parts.append(_curtain(min(detail, 2)))
    else:
        parts += [_ear(config, side, 7 * detail) for side in (1, -1)]
    if config.hair_style == "bun":
        parts.append(_bun(7 * detail))
    return merge(*parts)


def eyeball(factor: int) -> Mesh:
    """The visible cap of an eyeball around its x axis; uv centred on the iris."""
    off = np.radians(refine(np.array([0, 14, 28, 42, 62, 85.0]), factor))[:, None]
    around = np.linspace(0, 2 * np.pi, 8 * factor + 1)[None]
    y, z = np.sin(off) * np.cos(around), np.sin(off) * np.sin(around)
    points = EYE_RADIUS * np.stack([np.cos(off) + 0 * around, y, z], -1)
    spread = off / np.radians(85) * 0.5
    return grid(points, np.stack([0.5 + spread * np.cos(around), 0.5 + spread * np.sin(around)], -1))
