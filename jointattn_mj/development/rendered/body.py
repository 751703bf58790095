"""The robot's body at the rendered table: it acts, moves its gaze, takes an image and says what is at its centre.

Every run of the rendered table uses this one: known gaze targets (``run``), continuous maps (``continuous``) and
growing resolution (``growing``).
"""

from typing import NamedTuple

import numpy as np

from jointattn_mj.development.rendered.senses import EMPTY_VIEW, CentralView, SensesConfig, central_view
from jointattn_mj.development.rendered.stage import Stage, StageConfig
from jointattn_mj.development.table.world import CAREGIVER, OPTION, TableConfig
from jointattn_mj.errors import ConfigError
from jointattn_mj.perception.pixels import PixelPerception
from jointattn_mj.scene.camera import direction_of
from jointattn_mj.scene.central_eye import CentralEye
from jointattn_mj.scene.world import WorldObservation

LOOKS_PER_FACE = 100
"""The calibration gives up after so many images for each face that it needs."""


class Witnessed(NamedTuple):
    """Ground truth of a step, for the log; the robot does not know it."""

    looks_at: int
    """Spot (0 to N - 1) at which the caregiver looks; N: at the robot."""
    option: int
    """Rule that the caregiver followed, as a position in ``table.caregiver.OPTIONS``."""
    object_there: bool
    """Whether an object lies where the robot looks."""


class Body:
    """Head, camera and hand of the robot, and the table before them.

    Attributes:
        stage: The table with bodies.
        perception: From images to percepts.
        face: (2,) head angles that bring the caregiver's face to the centre of view, rad; (0, 0) before ``calibrate``.
    """

    def __init__(self, table: TableConfig, stage: StageConfig, senses: SensesConfig, seed: np.random.SeedSequence):
        """Build the scene.

        Args:
            table: Rules of the table.
            stage: Looks and imprecision of bodies.
            senses: Settings of perception.
            seed: Of looks and imprecision.
        """
        self.stage = Stage(table, stage, seed)
        self.perception = PixelPerception(senses.pixels, np.array([item.rgb for item in self.stage.objects]))
        self.face = np.zeros(2)
        self._observation = WorldObservation(self.stage.world)
        self._senses = senses

    def perceive(self) -> CentralView:
        """Take an image; returns what is at its centre."""
        return central_view(self.perception, self._observation, self._senses.centre_radius_px)

    def calibrate(self, faces: int) -> list[np.ndarray]:
        """Look at the caregiver, who looks at the robot, until ``faces`` frontal faces were at the centre of view.

        The first look is straight ahead; the mean of all directions in which the face was seen becomes ``face``.

        Returns:
            Their patterns, (d,) each.

        Raises:
            ConfigError: Too few faces were found.
        """
        self.face, patterns, visible = np.zeros(2), list[np.ndarray](), 0
        for _ in range(LOOKS_PER_FACE * faces):
            self.stage.face_to_face(self.face)
            view = self.perceive()
            if view.pattern is not None:
                patterns.append(view.pattern)
            if not np.isnan(view.face_px).any():
                visible += 1
                self.face += (np.radians(self.direction(view.face_px)) - self.face) / visible
            if len(patterns) == faces:
                return patterns
        raise ConfigError(
            f"the robot found {len(patterns)} of {faces} faces to look at in {LOOKS_PER_FACE * faces} images; "
            "change stage.variation, or the scene"
        )

    def narrow(self) -> None:
        """From the next image on, draw no more of it than tells what is at its centre, and perceive no more."""
        pixels = self._senses.pixels  # a face is searched around where it is expected
        around = max(self.perception.faces.reach_px + pixels.faces.search_radius_px, pixels.colours.reach_px)
        eye = CentralEye(self.stage.world.physics, self._senses.centre_radius_px + around)
        self.stage.world.eye = eye
        self.perception.narrow(eye.part)

    def act(self, action: np.ndarray) -> None:
        """Advance the table by a step, without an image.

        Args:
            action: (2,) spot to look at, or the number of spots for the caregiver's face; and the gesture.
        """
        self.stage.step(action)

    def observe(self, gesture: int, heads: np.ndarray, looks: bool = True) -> CentralView:
        """Move all bodies to where the table's last step has put them, and take an image.

        Args:
            gesture: The robot's.
            heads: (spots + 1, 2) head angles for each spot and for the caregiver's face, rad.
            looks: Whether an image is needed; without one, nothing is seen.

        Returns:
            What is at the centre of view.
        """
        self.stage.show(gesture, heads)
        return self.perceive() if looks else EMPTY_VIEW

    def direction(self, pixel: np.ndarray) -> np.ndarray:
        """Head angles (2,), deg, that would bring a ``pixel`` (2,) of the last image to the centre of view."""
        return direction_of(pixel, np.degrees(self.stage.world.head_angles()))

    def witnessed(self) -> Witnessed:
        """Ground truth of the table's last step."""
        stage = self.stage
        return Witnessed(int(stage.table.state[CAREGIVER]), int(stage.table.state[OPTION]), bool(stage.sensors[1] == 0))

    def close(self) -> None:
        """Free model, data and rendering context."""
        self.stage.world.close()
