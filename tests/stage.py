"""For tests of perception: the scene posed by hand, through the robot's eye. Degrees; pixels x right, y down."""

import cv2
import mujoco
import numpy as np

from jointattn_mj.scene.model import SceneConfig, build_model


class Stage:
    """A model whose head, neck and objects are put where a test wants them."""

    def __init__(self, config: SceneConfig | None = None):
        self.model = build_model(config or SceneConfig())
        self.data = mujoco.MjData(self.model)
        self.renderer = mujoco.Renderer(self.model, 240, 320)
        mujoco.mj_forward(self.model, self.data)
        self.eye = np.zeros(2)

    def look_from(self, pan: float, tilt: float) -> None:
        """Turn the robot's head."""
        self.eye = np.array([pan, tilt], float)
        self._set("robot/pan", pan)
        self._set("robot/tilt", tilt)

    def turn_face(self, yaw: float, pitch: float) -> None:
        """Turn the caregiver's head; pitch is positive with the nose down."""
        self._set("caregiver/neck_yaw", yaw)
        self._set("caregiver/neck_pitch", pitch)

    def put(self, name: str, location: tuple[float, float, float]) -> None:
        """Put an object's centre somewhere, metres."""
        self.data.mocap_pos[self.model.body(f"object/{name}").mocapid[0]] = location

    def location_of(self, name: str) -> np.ndarray:
        """An object's centre, (3,) metres."""
        return self.data.mocap_pos[self.model.body(f"object/{name}").mocapid[0]].copy()

    def image(self) -> np.ndarray:
        """(240, 320, 3) uint8."""
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)
        self.renderer.update_scene(self.data, "robot/eye")
        return self.renderer.render()

    def gray(self) -> np.ndarray:
        """(240, 320) uint8."""
        return cv2.cvtColor(self.image(), cv2.COLOR_RGB2GRAY)

    def face_px(self) -> np.ndarray:
        """Where the centre of the caregiver's head truly is."""
        return self.pixel(self.data.site("caregiver/face").xpos)

    def pixel(self, point: np.ndarray) -> np.ndarray:
        """Pixel of a point in the world, by the camera's own pose."""
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)
        camera = self.data.cam("robot/eye")
        right, up, back = camera.xmat.reshape(3, 3).T @ (np.asarray(point) - camera.xpos)
        focal = 120 / np.tan(np.radians(self.model.camera("robot/eye").fovy[0]) / 2)
        return np.array([159.5 - focal * right / back, 119.5 + focal * up / back])

    def close(self) -> None:
        """Free the OpenGL context."""
        self.renderer.close()

    def _set(self, joint: str, angle: float) -> None:
        self.data.qpos[self.model.joint(joint).qposadr[0]] = np.radians(angle)


def minimum_jerk(frames: int) -> np.ndarray:
    """Progress 0..1 of a smooth movement, frame by frame."""
    time = np.arange(1, frames + 1) / frames
    return time**3 * (10 - 15 * time + 6 * time**2)
