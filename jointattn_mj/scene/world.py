"""The world of chapter 6: model, caregiver, objects and the robot's body, one camera frame at a time.

Knows MuJoCo and no environment API: the session steps a ``World`` directly, and the dm_control task steps the same
``World`` over its own physics.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Self

import mujoco
import numpy as np
from dm_control.mujoco import Physics
from dm_control.mujoco.wrapper import MjModel

from jointattn_mj.errors import NotFiniteError
from jointattn_mj.guards.closing import Closable
from jointattn_mj.guards.finite import check_finite
from jointattn_mj.guards.restored import check_array
from jointattn_mj.io.compiled import njit
from jointattn_mj.options import Checked
from jointattn_mj.scene import snapshot
from jointattn_mj.scene.camera import Eye
from jointattn_mj.scene.caregiver import FRAME_S, CaregiverConfig, TransferScript
from jointattn_mj.scene.delay import Past
from jointattn_mj.scene.dressing import Conditions, Wardrobe, upload
from jointattn_mj.scene.layout import LayoutConfig
from jointattn_mj.scene.model import SceneConfig, build_model, rest_height
from jointattn_mj.scene.movement import ARM_JOINTS, Arm
from jointattn_mj.scene.rendering import RenderingPhysics

EYE_JOINTS = ("eye_left_yaw", "eye_left_pitch", "eye_right_yaw", "eye_right_pitch")
SCRIPTED_JOINTS = tuple(f"caregiver/{name}" for name in ("neck_yaw", "neck_pitch", *EYE_JOINTS, *ARM_JOINTS))
HEAD_JOINTS = ("robot/pan", "robot/tilt")
HEAD_STILL_DEG_S = 0.5
"""Below this speed the head counts as still: less than a tenth of a pixel from one image to the next."""

UNSTABLE = tuple(getattr(mujoco.mjtWarning, f"mjWARN_BAD{name}") for name in ("QPOS", "QVEL", "QACC", "CTRL"))
"""What MuJoCo counts when it meets NaN or huge numbers."""
_HEAD_STILL = np.radians(HEAD_STILL_DEG_S)


@dataclass(frozen=True)
class WorldConfig(Checked):
    """Everything about the world outside the robot's mind."""

    scene: SceneConfig = field(default_factory=SceneConfig)
    """What things look like."""
    behaviour: CaregiverConfig = field(default_factory=CaregiverConfig)
    """How the caregiver moves."""
    layout: LayoutConfig = field(default_factory=LayoutConfig)
    """Where objects may lie."""


def steps_per_frame(model: mujoco.MjModel) -> int:
    """Physics steps in one camera frame."""
    return round(FRAME_S / model.opt.timestep)


AS_USUAL = Conditions()
"""The scene's own light and colours, and a camera without faults."""


def build_physics(config: WorldConfig, conditions: Conditions = AS_USUAL) -> Physics:
    """dm_control's physics over the compiled scene, with textures where ``conditions`` put patterns on them."""
    return RenderingPhysics.from_model(MjModel(build_model(config.scene, blank=conditions.surfaces.contrast > 0)))


class World(Closable):
    """Body and script over a physics; one ``step`` is one camera frame of 1/30 s, or ``frames`` of them."""

    frames: int = 1
    """Camera frames in a step, in which whatever moves does so steadily; more are for worlds that derive from this."""

    def __init__(
        self, config: WorldConfig, physics: Physics, seed: np.random.SeedSequence, conditions: Conditions = AS_USUAL
    ):
        self._bind(config, physics)
        self.vary(config, conditions)
        self.reset(seed)

    def _bind(self, config: WorldConfig, physics: Physics) -> None:
        """Look up where in the model everything is."""
        self.config, self.physics = config, physics
        self.model = model = physics.model.ptr
        self.data = physics.data.ptr
        self.eye = Eye(physics)
        scripted, head = (_spans(model, names) for names in (SCRIPTED_JOINTS, HEAD_JOINTS))
        self._script_angles, self._script_speeds = self.data.qpos[scripted[0]], self.data.qvel[scripted[1]]
        self._face_angles = self._script_angles[:2]
        self._head_angles, self._head_speeds = self.data.qpos[head[0]], self.data.qvel[head[1]]
        objects = _span([model.body(f"object/{item.name}").mocapid[0] for item in config.scene.objects])
        self._object_locations = self.data.mocap_pos[objects]
        self._controls = self.data.ctrl
        self._steps = self.frames * steps_per_frame(model)
        self._wardrobe: Wardrobe | None = None
        self._image: np.ndarray | None = None

    @classmethod
    def build(cls, config: WorldConfig, seed: np.random.SeedSequence, conditions: Conditions = AS_USUAL) -> Self:
        """A world over a physics of its own."""
        return cls(config, build_physics(config, conditions), seed, conditions)

    def vary(self, config: WorldConfig, conditions: Conditions) -> None:
        """Look otherwise from the next ``reset`` on, and behave otherwise, as ``variation.drawn`` has it.

        Who she is and what objects are called stays as it was compiled.
        """
        if config is not self.config or conditions != AS_USUAL:
            self._wardrobe = self._wardrobe or Wardrobe(self.model)
        if self._wardrobe is not None:
            upload(self.physics, self._wardrobe.dress(config.scene, conditions))
        self.config, self.conditions = config, conditions
        self._past = Past(conditions.sensor.delay / self.frames)

    def reset(self, seed: np.random.SeedSequence) -> None:
        """Begin anew: another table, the caregiver about to greet, the robot's head straight ahead."""
        mujoco.mj_resetData(self.model, self.data)
        mujoco.mj_forward(self.model, self.data)
        head = self.data.site("caregiver/face").xpos.copy()
        arm = Arm.from_model(self.model, np.radians(self.config.behaviour.hand_pitch_deg))
        self.caregiver = self.new_caregiver(head, arm, np.random.default_rng(seed))
        self._script_angles[:] = self.caregiver.joints
        self._object_locations[:] = self.caregiver.objects
        mujoco.mj_forward(self.model, self.data)
        self._objects_before = self.caregiver.objects.copy()
        self._points = np.vstack([self.caregiver.objects, self.data.site("caregiver/face").xpos])
        self._past.forget()
        self.rendered_frames = 0
        self._image = None

    def new_caregiver(self, head: np.ndarray, arm: Arm, rng: np.random.Generator) -> TransferScript:
        """Who sits at the table, for an episode; ``head`` (3,) is the head's centre, world frame, metres."""
        config = self.config
        objects, height = len(config.scene.objects), rest_height(config.scene)
        return TransferScript(config.behaviour, config.layout, objects, height, head, arm, rng)

    def step(self, command: np.ndarray) -> None:
        """One frame: the caregiver moves on, the head's servos follow ``command`` (pan, tilt; rad)."""
        self.before_step(command)
        mujoco.mj_step2(self.model, self.data)
        if self._steps > 1:
            mujoco.mj_step(self.model, self.data, self._steps - 1)
        mujoco.mj_step1(self.model, self.data)

    def before_step(self, command: np.ndarray) -> None:
        """Set controls, the script's joint velocities and the objects for the frame that is about to be simulated.

        The caregiver's joints have so much inertia that they keep the velocity given here, and arrive at the script's
        angles exactly when the frame ends.
        """
        caregiver = self.caregiver
        self._past.note(self.data)
        self._objects_before[:] = caregiver.objects
        for _ in range(self.frames):
            caregiver.advance()
        self._controls[:] = command
        _set_out(
            caregiver.joints, self._script_angles, self._script_speeds, caregiver.objects, self._object_locations,
            self.frames * FRAME_S,
        )  # fmt: skip
        self._image = None

    def image(self) -> np.ndarray:
        """What the robot's eye sees now, uint8 (240, 320, 3); rendered at the first call in a frame."""
        if self._image is None:
            self._image = self._look()
            self.rendered_frames += 1
        return self._image

    def _look(self) -> np.ndarray:
        sensor = self.conditions.sensor
        if sensor.delay:
            with self._past.shown(self.model, self.data):
                image = self.eye.look()
        else:
            image = self.eye.look()
        sensor.expose(image, round(self.data.time / FRAME_S))
        return image

    def head_angles(self) -> np.ndarray:
        """Pan and tilt of the robot's head, (2,), rad."""
        return self._head_angles.copy()

    def head_velocity(self) -> np.ndarray:
        """Its angular velocity, (2,), rad/s."""
        return self._head_speeds.copy()

    def head_moves(self) -> bool:
        """Whether the robot's head turns; while it does, flow in the image is its own."""
        pan, tilt = self._head_speeds
        return max(abs(pan), abs(tilt)) > _HEAD_STILL

    def face_angles(self) -> np.ndarray:
        """Yaw and pitch of the caregiver's head, (2,), rad; they hold until the next step."""
        return self._face_angles

    def face_angles_deg(self) -> np.ndarray:
        """The same in degrees."""
        return np.degrees(self._face_angles)

    def candidate_points(self) -> np.ndarray:
        """Centres of the objects and, last, of the caregiver's head: (n + 1, 3), metres."""
        self._points[:-1] = self.caregiver.objects
        return self._points

    def moving(self, face_above_deg_s: float, object_above_m_s: float) -> np.ndarray:
        """Which of the candidates moved faster than this in the last frame: (n + 1,) bool."""
        face = np.linalg.norm(self._script_speeds[:2])
        path = self.caregiver.objects - self._objects_before
        moved = np.empty(len(path) + 1, bool)
        np.greater(np.einsum("ij,ij->i", path, path), (object_above_m_s * FRAME_S) ** 2, out=moved[:-1])
        moved[-1] = face > np.radians(face_above_deg_s)
        return moved

    def check(self) -> None:
        """Go on only with a simulation that is stable.

        Raises:
            NotFiniteError: Joints are where no number says, or MuJoCo has begun anew because they were.
        """
        check_finite({"joint angles": self.data.qpos, "joint velocities": self.data.qvel, "controls": self.data.ctrl})
        if any(self.data.warning[kind].number for kind in UNSTABLE):
            raise NotFiniteError(
                "the simulation became unstable: some option of the caregiver's or the robot's movement is too large"
            )

    def close(self) -> None:
        """Free model, data and rendering context; whatever the world is asked for afterwards is a ``ClosedError``."""
        if not self.closed:
            self.physics.free()
            self._shut()

    def get_state(self) -> dict[str, Any]:
        """Everything that the next frame depends on, as plain data; nothing that happens later changes it."""
        return {name: snapshot.take(value) for name, value in self.__getstate__().items()}

    def set_state(self, state: dict[str, Any]) -> None:
        """Be as a world with the same people and objects was at its ``get_state``; ``state`` can be used again."""
        config, conditions = state["config"], state["conditions"]
        if (config, conditions) != (self.config, self.conditions):
            self.vary(config, conditions)
        for name in state.keys() - {"integration", "config", "conditions"}:
            setattr(self, name, snapshot.put(getattr(self, name), state[name]))
        self._integrate_from(state["integration"])

    def __getstate__(self) -> dict[str, Any]:
        """Everything that the next frame depends on; the model is built anew from the config."""
        integration = np.empty(mujoco.mj_stateSize(self.model, mujoco.mjtState.mjSTATE_INTEGRATION))
        mujoco.mj_getState(self.model, self.data, integration, mujoco.mjtState.mjSTATE_INTEGRATION)
        kept = ("config", "conditions", "caregiver", "rendered_frames", "_objects_before", "_points", "_past")
        return {"integration": integration, **{name: getattr(self, name) for name in kept}}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a world. Raises ValueError: Its physics is in no state that MuJoCo could go on from."""
        state = dict(state)
        integration = state.pop("integration")
        most = mujoco.mjMAXVAL
        check_array("the state of the physics", integration, integration.shape, float, -most, most)
        config, conditions = state["config"], state["conditions"]
        self._bind(config, build_physics(config, conditions))
        self.vary(config, conditions)
        self.__dict__.update(state)
        self._integrate_from(integration)

    def _integrate_from(self, integration: np.ndarray) -> None:
        """Let bodies stand and move as they did in another world with the same model."""
        mujoco.mj_setState(self.model, self.data, integration, mujoco.mjtState.mjSTATE_INTEGRATION)
        mujoco.mj_step1(self.model, self.data)
        self._image = None


@njit(cache=True)
def _set_out(joints, angles, speeds, objects, locations, seconds):
    """Speeds that bring ``angles`` to ``joints`` in time, and objects to where they are: one call, not four."""
    speeds[:] = (joints - angles) / seconds
    locations[:] = objects


def _span(addresses: Sequence[int]) -> slice:
    """Consecutive addresses as a slice, through which numpy reads and writes without copying."""
    first, count = addresses[0], len(addresses)
    if list(addresses) != list(range(first, first + count)):
        raise ValueError(f"the scene must list these one after the other; got addresses {list(addresses)}")
    return slice(first, first + count)


def _spans(model: mujoco.MjModel, joints: Sequence[str]) -> tuple[slice, slice]:
    """Where the joints' angles and speeds lie in qpos and qvel."""
    found = [model.joint(name) for name in joints]
    return _span([joint.qposadr[0] for joint in found]), _span([joint.dofadr[0] for joint in found])


class Observation(Mapping[str, np.ndarray]):
    """What the robot may know of a world in this frame; the image is rendered when, and only when, it is read.

    Keys: ``camera`` uint8 (240, 320, 3); ``head_angles`` (2,) pan and tilt, rad; ``head_moves`` bool.
    """

    _READ: ClassVar[dict[str, Callable[[World], Any]]] = {
        "camera": World.image,
        "head_angles": World.head_angles,
        "head_moves": World.head_moves,
    }

    def __init__(self, world: World):
        self._world = world

    def __getitem__(self, key: str) -> np.ndarray:
        return self._READ[key](self._world)

    def __iter__(self) -> Iterator[str]:
        return iter(self._READ)

    def __len__(self) -> int:
        return len(self._READ)
