"""Who looks where: geometry of a scene, without randomness or reward."""

from functools import cached_property

import numpy as np

from jointattn_mj.errors import StateError
from jointattn_mj.scene.camera import PIVOT, in_image, pixels_of_points
from jointattn_mj.scene.rendering import RenderingPhysics
from jointattn_mj.scene.servo import HEAD_JOINTS

ROBOT_RADIUS = np.radians(3.5)
"""The robot fixates a target within this angle, rad, of its line of sight ("around the center of the view", 6.3.1)."""
CAREGIVER_RADIUS = np.radians(5.0)
"""The same for the caregiver. The eyes sit before the head's centre of rotation, so that the line of sight passes an
object at up to two degrees."""


class Physics(RenderingPhysics):
    """dm_control's physics with questions about gaze.

    Targets have the numbers of the robot's candidates: the n objects, then, as n, the partner's face. Points are in the
    world frame, metres; angles in radians.
    """

    scripted: bool = False
    """Whether a script moves the caregiver and the objects, as in an environment."""

    def set_state(self, physics_state: np.ndarray, sig: int | None = None) -> None:
        """See dm_control's ``Physics``.

        Raises:
            StateError: The bodies are moved by a script, which would go on from elsewhere.
        """
        if self.scripted:
            raise StateError(
                "physics.set_state would leave the caregiver's script, the clock and random streams as they are; "
                "use state = environment.get_state() and environment.set_state(state), or, to look at bodies alone, "
                "physics.copy()"
            )
        super().set_state(physics_state, sig)

    @cached_property
    def object_names(self) -> tuple[str, ...]:
        """Names of the objects: n texts."""
        bodies = (self.model.id2name(i, "body") for i in range(self.model.nbody))
        return tuple(name.removeprefix("object/") for name in bodies if name.startswith("object/"))

    @cached_property
    def _object_ids(self) -> np.ndarray:
        return np.array([self.model.name2id(f"object/{name}", "body") for name in self.object_names])

    @cached_property
    def _ids(self) -> dict[str, int]:
        kinds = {"robot/eye": "camera", "caregiver/face": "site"}
        kinds |= {"caregiver/eye_left": "body", "caregiver/eye_right": "body"}
        return {name: self.model.name2id(name, kind) for name, kind in kinds.items()}

    def object_positions(self) -> np.ndarray:
        """Centres of the objects, (n, 3), world frame, metres."""
        positions: np.ndarray = self.data.xpos[self._object_ids]
        return positions

    def face_position(self) -> np.ndarray:
        """Centre of the caregiver's head, (3,), world frame, metres."""
        position: np.ndarray = self.data.site_xpos[self._ids["caregiver/face"]].copy()
        return position

    def head_angles(self) -> np.ndarray:
        """Pan and tilt of the robot's head, (2,), rad."""
        return np.array([self.named.data.qpos[name][0] for name in HEAD_JOINTS])

    def robot_sight(self) -> tuple[np.ndarray, np.ndarray]:
        """The robot's line of sight, world frame: where it starts, (3,), metres, and its unit direction (3,)."""
        eye = self._ids["robot/eye"]
        return self.data.cam_xpos[eye].copy(), -self.data.cam_xmat[eye].reshape(3, 3)[:, 2]

    def caregiver_sight(self) -> tuple[np.ndarray, np.ndarray]:
        """The caregiver's line of sight, likewise: from midway between the eyes, along the mean of their directions."""
        eyes = [self._ids["caregiver/eye_left"], self._ids["caregiver/eye_right"]]
        ahead = self.data.xmat[eyes].reshape(2, 3, 3)[:, :, 0].sum(axis=0)
        return self.data.xpos[eyes].mean(axis=0), ahead / np.linalg.norm(ahead)

    def robot_to_targets(self) -> np.ndarray:
        """Angles (n + 1,), rad, from the robot's line of sight to the objects and to the caregiver's face."""
        return _angles(*self.robot_sight(), np.vstack([self.object_positions(), self.face_position()]))

    def caregiver_to_targets(self) -> np.ndarray:
        """Angles (n + 1,), rad, from the caregiver's line of sight to the objects and to the robot's face."""
        return _angles(*self.caregiver_sight(), np.vstack([self.object_positions(), PIVOT]))

    def robot_fixates(self, radius: float = ROBOT_RADIUS) -> int | None:
        """Target nearest to the robot's line of sight, n for the caregiver's face; None beyond ``radius``, rad."""
        return _nearest(self.robot_to_targets(), radius)

    def caregiver_fixates(self, radius: float = CAREGIVER_RADIUS) -> int | None:
        """Target nearest to the caregiver's line of sight, n for the robot; None beyond ``radius``, rad."""
        return _nearest(self.caregiver_to_targets(), radius)

    def joint_attention(self) -> bool:
        """Whether robot and caregiver look at the same object."""
        fixated = self.robot_fixates()
        return fixated is not None and fixated < len(self.object_names) and fixated == self.caregiver_fixates()

    def in_view(self) -> np.ndarray:
        """Which targets' centres lie inside the robot's image, hidden or not: (n + 1,) bool."""
        targets = np.vstack([self.object_positions(), self.face_position()])
        pixels = pixels_of_points(targets, np.degrees(self.head_angles()))
        return in_image(pixels) & (self.robot_to_targets() < np.pi / 2)


def _angles(origin: np.ndarray, direction: np.ndarray, points: np.ndarray) -> np.ndarray:
    along = points - origin
    across = np.linalg.norm(np.cross(along, direction), axis=1)
    angles: np.ndarray = np.arctan2(across, along @ direction)
    return angles


def _nearest(angles: np.ndarray, radius: float) -> int | None:
    nearest = int(np.argmin(angles))
    return nearest if angles[nearest] <= radius else None
