"""The robot's own perception: everything from the camera picture (boxes left of the attention selector in Fig. 6.2)."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from jointattn_mj.perception.faces import PATCH_SIDE, FaceDetector, FaceDetectorConfig
from jointattn_mj.perception.motion import Motion, MotionConfig, MotionDetector
from jointattn_mj.perception.objects import ColourAreas, ColourConfig
from jointattn_mj.perception.percept import Percept
from jointattn_mj.scene.camera import direction_of, pixel_of

MEMORY_RATE = 0.02
"""Share of each new look in the remembered direction of the face, which says where to search for it."""


@dataclass(frozen=True)
class PixelConfig:
    """Options of the pixel path, part by part."""

    faces: FaceDetectorConfig = field(default_factory=FaceDetectorConfig)
    """Face detection by template matching."""
    colours: ColourConfig = field(default_factory=ColourConfig)
    """Objects as colour areas."""
    motion: MotionConfig = field(default_factory=MotionConfig)
    """Optical flow by block matching."""


class PixelPerception:
    """Looks at the picture; knows nothing of the world but the colours of the objects that interest it.

    Attributes:
        fix: The last answer of the face detector.
        motion: The last answer of the motion detector, with its flow vectors.
    """

    pattern_size = PATCH_SIDE**2

    def __init__(self, config: PixelConfig, rgb: np.ndarray):
        """``rgb`` (n, 3): the objects' nominal colours, 0..1."""
        self.faces = FaceDetector(config.faces)
        self.colours = ColourAreas(rgb, config.colours)
        self._motion = MotionDetector(config.motion)
        self._face_direction: np.ndarray | None = None
        self._gray = np.empty((0, 0), np.uint8)
        self.motion: Motion | None = None
        candidates = len(rgb) + 1
        self._percept = Percept(np.zeros(candidates, bool), np.full((candidates, 2), np.nan), np.zeros(candidates, bool))

    def look(self, observation: Mapping[str, np.ndarray], landed: bool) -> Percept:
        """Face, colour areas and motion of this picture; ``landed`` begins a new history of motion."""
        head = np.degrees(observation["head_angles"])
        self._gray, areas = self.colours.segment(observation["camera"])
        known = self._face_direction
        self.fix = fix = self.faces.detect(self._gray, None if known is None else tuple(pixel_of(known, head)))
        if fix.found:
            direction = direction_of((fix.x, fix.y), head)
            self._face_direction = direction if known is None else known + MEMORY_RATE * (direction - known)
        if landed:
            self._motion.reset()
        box = self.faces.box(fix, self._gray.shape) if fix.found else None
        self.motion = self._motion.update(self._gray, box, areas)
        percept = self._percept
        percept.seen[:-1], percept.seen[-1] = areas.seen, fix.found
        percept.px[:-1], percept.px[-1] = areas.px, (fix.x, fix.y)
        percept.moves[:-1], percept.moves[-1] = self.motion.object_moves, self.motion.face_moves
        return percept

    def face_pattern(self) -> np.ndarray:
        """The 32x32 grey patch f_v around the face of the last look, (1024,) float32."""
        return self.faces.patch(self._gray, self.fix).ravel()
