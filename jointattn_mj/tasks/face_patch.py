"""The caregiver's face as an observation: the patch that the robot's own detector cuts out (section 6.4.1)."""

from collections import OrderedDict
from collections.abc import Iterable
from copy import deepcopy

import numpy as np
from dm_env import specs

from jointattn_mj.perception.faces import PATCH_SIDE, FaceDetectorConfig
from jointattn_mj.perception.objects import Areas
from jointattn_mj.perception.percept import StillObservation
from jointattn_mj.perception.pixels import PixelConfig, PixelPerception
from jointattn_mj.perception.sitter import Sitter
from jointattn_mj.scene.camera import directions_to
from jointattn_mj.scene.world import World

SPEC: OrderedDict[str, specs.Array] = OrderedDict(
    face_patch=specs.BoundedArray((PATCH_SIDE, PATCH_SIDE), np.uint8, 0, 255, name="face_patch"),
    face_visible=specs.Array((), bool, name="face_visible"),
)
"""Shapes and bounds of what ``FacePatch.observe`` returns."""


class NoObjects:
    """An object detector for those who ask for the face alone."""

    def nothing(self) -> Areas:
        """Areas of no object."""
        return Areas.empty(0, 1)

    def find(self, image: np.ndarray, gray: np.ndarray, areas: Areas) -> None:
        """Detect nothing.

        Args:
            image: RGB image (h, w, 3) uint8.
            gray: (h, w) uint8.
            areas: Left as it is.
        """


class FacePatch:
    """A robot that has seen the faces of all caregivers of a task, and finds them again in its images.

    What it learns of a face during an episode is forgotten at the next one, so that an episode depends on its seed
    alone.
    """

    def __init__(self, people: Iterable[tuple[World, float]]):
        """Get to know all faces: each caregiver looks at the robot, then over the table; 250 images each.

        Args:
            people: A world with each caregiver, which must be reset before it is used for anything else, and the share
                of a gaze shift that the caregiver's head makes.

        Raises:
            GLError: No image can be rendered here.
        """
        people = list(people)
        views = FaceDetectorConfig().max_views * len(people)
        config = PixelConfig(FaceDetectorConfig(max_views=views))
        familiar = PixelPerception(config, np.zeros((0, 3)), objects=NoObjects())
        for world, head_share in people:
            face = directions_to(world.data.site("caregiver/face").xpos[None])[0]
            Sitter(world, head_share, familiar).sweep(face)
        self._familiar = familiar
        self.begin()

    def begin(self) -> None:
        """Begin an episode."""
        self._perception = deepcopy(self._familiar)

    def observe(self, image: np.ndarray, head_angles: np.ndarray) -> OrderedDict[str, np.ndarray]:
        """Find the face in the next image.

        Args:
            image: The robot's image, uint8 (240, 320, 3) RGB.
            head_angles: (2,) pan and tilt of its head, rad.

        Returns:
            ``face_patch``: grey values, uint8 (32, 32), 0 where no face was found; ``face_visible``: whether one was.
        """
        visible = self._perception.glance(StillObservation(image, head_angles)).visible[-1]
        patch = np.zeros((PATCH_SIDE, PATCH_SIDE), np.uint8)
        if visible:
            patch[:] = np.rint(self._perception.face_pattern()).reshape(patch.shape).clip(0, 255)
        return OrderedDict(face_patch=patch, face_visible=np.array(visible))

    def get_state(self) -> PixelPerception:
        """What this episode depends on; later images do not change it."""
        return deepcopy(self._perception)

    def set_state(self, state: PixelPerception | None) -> None:
        """Go back to a state; None: to the beginning of an episode."""
        self._perception = deepcopy(self._familiar if state is None else state)
