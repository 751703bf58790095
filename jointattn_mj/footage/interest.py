"""Which of several faces is the face of interest."""

import re
from dataclasses import dataclass

from jointattn_mj.errors import ConfigError
from jointattn_mj.footage.people import Sighting

LARGER = 1.3
"""How much larger another face must be to take the place of the largest one."""
PATIENCE = 30
"""Frames for which another face must be larger, or the face of interest gone, before another takes its place."""


@dataclass(frozen=True)
class FaceRule:
    """Which face is wanted: a person, whatever is in a region, or (neither) the largest."""

    person: int | None = None
    region: tuple[float, float, float, float] | None = None
    """x0, y0, x1, y1, pixels of the video."""

    @classmethod
    def parsed(cls, text: str) -> "FaceRule":
        """The rule in words: ``largest``, the number of a person, or ``x0,y0,x1,y1``.

        Raises:
            ConfigError: It is none of these.
        """
        if text == "largest":
            return cls()
        if re.fullmatch(r"[1-9]\d{0,5}", text):
            return cls(person=int(text))
        parts = text.split(",")
        if len(parts) == 4 and all(re.fullmatch(r"\d+(\.\d+)?", part.strip()) for part in parts):
            x0, y0, x1, y1 = map(float, parts)
            if x0 < x1 and y0 < y1:
                return cls(region=(x0, y0, x1, y1))
        raise ConfigError(
            "face: expected largest, the number of a person, or a region x0,y0,x1,y1 in pixels of the video; "
            f"got {text!r}"
        )


class FaceOfInterest:
    """Chooses the face of interest in each image, and keeps to it. It can be pickled."""

    def __init__(self, rule: FaceRule):
        self._rule = rule
        self._track = 0
        self._challenged = 0
        self._missing = 0
        self._frame = 0  # of the last image

    def choose(self, faces: list[Sighting], frame: int, cut: bool) -> Sighting | None:
        """The face of interest in an image; None if it is not there.

        Args:
            faces: The faces in the image, the largest first.
            frame: Number of the frame.
            cut: Whether the image follows upon a cut.
        """
        rule, passed = self._rule, frame - self._frame
        self._frame = frame
        if rule.person is not None:
            return next((face for face in faces if face.person == rule.person), None)
        if rule.region is not None:
            x0, y0, x1, y1 = rule.region
            return next((face for face in faces if x0 <= face.centre[0] <= x1 and y0 <= face.centre[1] <= y1), None)
        own = None if cut else next((face for face in faces if face.track == self._track), None)
        if own is None:
            self._missing = PATIENCE + 1 if cut else self._missing + passed
            if not faces or (self._track and self._missing <= PATIENCE):
                return None
            own = faces[0]
        self._missing = 0
        larger = faces[0].smooth[3] > LARGER * own.smooth[3]
        self._challenged = self._challenged + passed if larger else 0
        if self._challenged > PATIENCE:
            own, self._challenged = faces[0], 0
        self._track = own.track
        return own
