"""One viewing of a video, frame by frame, without files."""

import math
from collections import deque
from itertools import islice
from typing import Any

import numpy as np

from jointattn_mj.errors import CheckpointError
from jointattn_mj.footage.colours import object_colours
from jointattn_mj.footage.config import PerceiveConfig
from jointattn_mj.footage.face_size import face_side, largest_scale
from jointattn_mj.footage.faces import EVERY, KEPT, FaceAlbum
from jointattn_mj.footage.fixations import Fixations
from jointattn_mj.footage.frame_map import FrameMap
from jointattn_mj.footage.reader import RATE, Footage, Still
from jointattn_mj.footage.watcher import Watcher
from jointattn_mj.perception.pixels import PixelPerception

STATE = (
    "watcher", "mapped", "fixations", "album", "frames", "face_side", "visible", "moves", "sample", "coloured", "sizes",
    "_faces",
)  # fmt: skip
"""Attributes that change from frame to frame; the rest follows from the config."""
GREY_SPREAD = 16
"""Difference between the channels of a pixel up to which it has no colour; compression makes small ones."""


class Viewing:
    """One viewing of a video, frame by frame.

    Attributes:
        footage: The video.
        watcher: Perception and attention.
        mapped: From pixels of the video to those of the robot's image; None before the first frame.
        frames: Number of frames so far.
        total: Number of frames to watch; infinite without ``config.max_minutes``.
        fixations: Fixations so far.
        album: Face patterns so far.
        face_side: Height of the face, pixels of the video; None if unknown.
        names: Of the candidates, the face last.
        rgb: (n, 3) colours of the objects, 0..1.
        visible: (n + 1,) number of frames in which each candidate was detected.
        moves: (n + 1,) number of frames in which it was detected to move.
        sample: One of the robot's images for the figure, (240, 320, 3) uint8 RGB: the first with a face.
        coloured: Whether any image had colours.
        sizes: Widths and heights of the video's images.
    """

    def __init__(self, config: PerceiveConfig):
        """Open the video.

        Raises:
            FootageError: There is no such file, or it is no video.
        """
        names, self.rgb = object_colours(config.objects)
        attention, album = (np.random.default_rng(seed) for seed in np.random.SeedSequence(config.seed).spawn(2))
        self.config, self.names = config, (*names, "face")
        self.footage = Footage(config.video, config.fps)
        perceiver = PixelPerception(config.pixels, self.rgb, config.face_follow)
        self.watcher = Watcher(perceiver, config.attention, len(names), config.shift_frames, attention)
        self.mapped: FrameMap | None = None
        self.fixations = Fixations()
        self.album = FaceAlbum(KEPT, perceiver.pattern_size, album)
        self.frames, self.total = 0, math.inf
        if config.max_minutes is not None:
            self.total = max(1, round(config.max_minutes * 60 * RATE))
        self.face_side: float | None = None
        self.visible = np.zeros(len(self.names), int)
        self.moves = np.zeros(len(self.names), int)
        self.coloured = False
        self.sizes: set[tuple[int, int]] = set()
        self.sample = np.zeros((1, 1, 3), np.uint8)
        self._faces = 0

    def __repr__(self) -> str:
        """In one line: video, progress and fixations."""
        return f"Viewing({self.footage.path}: {self.frames} frames, {len(self.fixations.all)} fixations)"

    def measure_face(self) -> None:
        """Measure the face, unless a scale is given, and check that the video can be read.

        Raises:
            FootageError: The video has no image, or neither timestamps nor a rate.
        """
        if self.config.scale is None:
            self.face_side = face_side(self.footage, self.config.fit, self.config.pixels.faces)
        else:
            deque(islice(self.footage, 2), maxlen=0)

    def see(self, still: Still) -> FrameMap:
        """Perceive and attend for one frame; returns the map from the video's image to the robot's."""
        self.mapped = mapped = self._map(still)
        first_face = self.visible[-1] == 0
        image = mapped.image(still.image) if still.fresh or self.frames == 0 else self.sample
        percept = self.watcher.see(image, still.fresh, still.cut)
        self.visible += percept.visible
        self.moves += percept.moves
        if still.fresh and percept.visible[-1]:
            if self._faces % EVERY == 0:
                self.album.add(self.watcher.perceiver.face_pattern(), self.frames / RATE)
            self._faces += 1
        if self.frames == 0 or (first_face and percept.visible[-1]):
            self.sample = image
        if still.fresh and self.frames % RATE == 0 and not self.coloured:
            spread = image.max(axis=2) - image.min(axis=2)
            self.coloured = bool(np.percentile(spread, 99) > GREY_SPREAD)
        self.fixations.note(self.watcher, self.frames, mapped)
        self.frames += 1
        return mapped

    def state(self) -> dict[str, Any]:
        """State from which a viewing of the same config can go on (see ``restore``)."""
        return {"bytes": self._bytes(), **{name: getattr(self, name) for name in STATE}}

    def restore(self, state: dict[str, Any]) -> None:
        """Take over what ``state`` gave.

        Raises:
            CheckpointError: It is no such state, or the video has changed.
        """
        for name in ("bytes", *STATE):
            now = self._bytes() if name == "bytes" else getattr(self, name)
            if name not in state or (now is not None and type(state[name]) is not type(now)):
                raise CheckpointError(f"the checkpoint has no {name} of a viewing; begin anew in another folder")
        if state["bytes"] != self._bytes():
            raise CheckpointError(
                f"{self.footage.path} had {state['bytes']} bytes when it was watched, and has {self._bytes()}; choose "
                "another folder to watch it anew"
            )
        vars(self).update({name: state[name] for name in STATE})

    def _bytes(self) -> int:
        return self.footage.path.stat().st_size

    def _map(self, still: Still) -> FrameMap:
        height, width = still.image.shape[:2]
        if self.mapped is not None and (self.mapped.width, self.mapped.height) == (width, height):
            return self.mapped
        self.sizes.add((width, height))
        aspect, fit, scale = self.footage.aspect, self.config.fit, self.config.scale
        if scale is not None:
            return FrameMap.scaled(width, height, aspect, scale)
        fitted = FrameMap.fitted(width, height, aspect, fit)
        most = largest_scale(self.face_side, fitted.scale_y, self.config.pixels.faces)
        return fitted if most == fitted.scale_y else FrameMap.scaled(width, height, aspect, most)
