"""The robot's perception before a wide image: faces are found there, objects and motion in its own image."""

import time
from typing import Any

import numpy as np

from jointattn_mj.footage.areas import FootageAreas
from jointattn_mj.footage.followed import FollowedFace
from jointattn_mj.footage.interest import FaceOfInterest, FaceRule
from jointattn_mj.footage.people import People, Sighting
from jointattn_mj.footage.perceiving import FootagePerception
from jointattn_mj.footage.rest import Rest
from jointattn_mj.footage.sessions.config import FootageSessionConfig
from jointattn_mj.footage.sessions.latency import Latency
from jointattn_mj.footage.sessions.lens import Lens
from jointattn_mj.footage.sessions.world import WideWorld
from jointattn_mj.footage.shots import Shots
from jointattn_mj.perception.faces import PATCH_SIDE
from jointattn_mj.perception.percept import Observation, Percept
from jointattn_mj.scene.camera import direction_of, pixel_of

RATE = 30


class HeadView:
    """The map from pixels of the wide image to those of the robot's, at one pose of the head and near one point."""

    def __init__(self, lens: Lens, head: np.ndarray, near: np.ndarray):
        """Make the map.

        Args:
            lens: Geometry of the wide image.
            head: (2,) pan and tilt, deg.
            near: (2,) pixel of the wide image near which ``scale_x`` and ``scale_y`` hold.
        """
        self._lens, self._head = lens, head
        here, right, below = lens.to_image(near + np.array([[0, 0], [1, 0], [0, 1]]), head)
        self.scale_x, self.scale_y = float(np.hypot(*(right - here))), float(np.hypot(*(below - here)))

    def to_image(self, px: np.ndarray) -> np.ndarray:
        """Pixels (..., 2) of the robot's image for pixels of the wide image."""
        px = np.asarray(px, float)
        return self._lens.to_image(px.reshape(-1, 2), self._head).reshape(px.shape)


class WidePerception(FootagePerception):
    """Percepts of a world behind a wide image.

    A frame that is shown again is not perceived again: it is no evidence of stillness.

    Attributes:
        seen: The faces in the last frame that was perceived, the largest first; empty with the detector templates.
        chosen: The face of interest among them; None where it is not there.
        fresh_frames: Number of perceived frames that showed a new image.
        latency: Times from the arrival of a camera's image to the percept.
    """

    def __init__(self, config: FootageSessionConfig, table: np.ndarray, world: WideWorld):
        """Make a perceiver.

        Args:
            config: What is looked for, and how.
            table: Label of each colour, as of ``footage.labels``.
            world: The world.
        """
        count = len(config.names)
        by_colour = np.array(["@" not in item for item in config.objects])
        areas = FootageAreas(table, by_colour, 1, config.pixels.colours, config.areas, RATE)
        people = config.detector == "yunet"
        super().__init__(
            config.pixels, areas, Rest(config.rest, count + 1), FollowedFace() if people else None, config.face_follow
        )
        self.people = People(config.people, RATE, config.face_follow) if people else None
        self.shots = Shots(config.shots)
        self.interest = FaceOfInterest(FaceRule.parsed(config.face))
        self.visible_faces: list[Sighting] = []
        self.chosen: Sighting | None = None
        self.fresh_frames = 0
        self.latency = Latency()
        self._world = world
        self._number = self._frame = -1  # of the image and the frame that were perceived last
        self._cuts = 0  # until then
        self._head = np.zeros(2)  # deg, at that time

    def __getstate__(self) -> dict[str, Any]:
        """All but the faces of the last frame."""
        return {**vars(self), "visible_faces": [], "chosen": None}

    def perceive(self, observation: Observation, landed: bool) -> Percept:
        """The percept of this frame; see ``perception.percept.Perceiver``."""
        wide_frame, head = self._world.wide_frame, np.degrees(observation.head_angles)
        fresh = wide_frame.number != self._number
        if not fresh and not landed:
            return self._percept
        self.pass_over(self._world.frames - self._frame - 1)
        turned = bool(np.abs(head - self._head).max() > 1e-3)
        if turned:
            before = self._head
            self.areas.turn(lambda px: pixel_of(direction_of(px, before), head))
        cut = False
        if fresh:
            self.fresh_frames += 1
            cut = self.shots.see(wide_frame.image) or self._world.cuts > self._cuts
            if self.people is not None:
                self.visible_faces = self.people.see(wide_frame.image, self._world.frames, cut)
                self.chosen = self.interest.choose(self.visible_faces, self._world.frames, cut)
            self._cuts = self._world.cuts
        self.areas.show_faces(self._boxes(wide_frame.image, head), cut, self.shots.shifted)
        self._number, self._frame, self._head = wide_frame.number, self._world.frames, head
        percept = super().perceive(observation, landed or cut or self.shots.camera_moves)
        if fresh and wide_frame.taken_s is not None:
            self.latency.add(time.monotonic() - wide_frame.taken_s)
        return percept

    def face_direction(self) -> np.ndarray | None:
        """Direction (2,), deg, of the face of interest, anywhere in the wide image; None where it is not known."""
        return None if self.chosen is None else self._world.lens.direction(self.chosen.centre - 0.5)

    def _boxes(self, wide_image: np.ndarray, head: np.ndarray) -> np.ndarray:
        """(k, 4) x, y, width and height of faces, pixels of the robot's image, that of interest first."""
        lens = self._world.lens
        if not isinstance(self.faces, FollowedFace):
            return self._template_box(head)
        boxes = []
        if self.chosen is None:
            self.faces.show(None, wide_image, HeadView(lens, head, np.zeros(2)))
        for sighting in sorted(self.visible_faces, key=lambda sighting: sighting is not self.chosen):
            view = HeadView(lens, head, sighting.centre - 0.5)
            if sighting is self.chosen:
                self.faces.show(sighting, wide_image, view)
            size = sighting.smooth[2:] * (view.scale_x, view.scale_y)
            boxes.append(np.concatenate([view.to_image(sighting.centre - 0.5) - size / 2, size]))
        squares: np.ndarray = np.array(boxes).reshape(-1, 4)
        known: np.ndarray = squares[np.isfinite(squares).all(axis=1)]
        return known

    def _template_box(self, head: np.ndarray) -> np.ndarray:
        """(1, 4) where the robot's own detector remembers the face to be; (0, 4) before it has found one."""
        if not self._knows_face:
            return np.zeros((0, 4))
        side = getattr(getattr(self.faces, "config", None), "side_px", PATCH_SIDE)
        x, y = pixel_of(self._face_direction, head)
        return np.array([[x - side / 2, y - side / 2, side, side]])
