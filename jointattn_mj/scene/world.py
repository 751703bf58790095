"""The world of chapter 6: caregiver, objects and the robot's body, simulated one camera frame at a time.

A session steps a ``World`` directly; a dm_control task steps it over the task's own physics.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import radians
from typing import Any, Literal, Self

import mujoco
import numpy as np
from dm_control.mujoco import Physics
from dm_control.mujoco.wrapper import MjModel

from jointattn_mj.errors import ConfigError, NotFiniteError
from jointattn_mj.guards.closing import Closable, closed_one
from jointattn_mj.guards.finite import check_finite
from jointattn_mj.guards.restored import check_array
from jointattn_mj.options import Checked
from jointattn_mj.scene import snapshot
from jointattn_mj.scene.camera import Eye
from jointattn_mj.scene.caregiver import FRAME_S, CaregiverConfig, TransferScript
from jointattn_mj.scene.delay import Past
from jointattn_mj.scene.dressing import Conditions, Wardrobe, upload
from jointattn_mj.scene.layout import LayoutConfig
from jointattn_mj.scene.model import SceneConfig, build_model, rest_height
from jointattn_mj.scene.motion import note_moves, run_closed_form, run_in_physics, set_out
from jointattn_mj.scene.movement import ARM_JOINTS, Arm
from jointattn_mj.scene.placing import place
from jointattn_mj.scene.redrawing import RedrawingEye
from jointattn_mj.scene.rendering import RenderingPhysics
from jointattn_mj.scene.servo import HEAD_JOINTS, Servos, steps_to_rest, turn
from jointattn_mj.scene.stepping import calls_python, half_steps
from jointattn_mj.scene.tape import Tape
from jointattn_mj.scene.warp_eye import WarpEye

EYE_JOINTS = ("eye_left_yaw", "eye_left_pitch", "eye_right_yaw", "eye_right_pitch")
SCRIPTED_JOINTS = tuple(f"caregiver/{name}" for name in ("neck_yaw", "neck_pitch", *EYE_JOINTS, *ARM_JOINTS))
HEAD_STILL_DEG_S = 0.5
"""Speed, degrees per second, below which the head counts as still: under a tenth of a pixel an image."""

UNSTABLE = tuple(getattr(mujoco.mjtWarning, f"mjWARN_BAD{name}") for name in ("QPOS", "QVEL", "QACC", "CTRL"))
"""MuJoCo's warnings of NaN and huge numbers."""
_HEAD_STILL = radians(HEAD_STILL_DEG_S)


@dataclass(frozen=True)
class WorldConfig(Checked):
    """The world outside the robot: looks, the caregiver's behaviour, and where objects may lie."""

    scene: SceneConfig = field(default_factory=SceneConfig)
    """What things look like."""
    behaviour: CaregiverConfig = field(default_factory=CaregiverConfig)
    """The caregiver's pace and ways of moving."""
    layout: LayoutConfig = field(default_factory=LayoutConfig)
    """Where objects may lie."""
    draws: Literal["all", "changes"] = "all"
    """What of an image is drawn while the head stands still: all of it, or the part in which something has moved. That
    takes half the time, and differs in a few pixels at the edges of things."""
    renderer: Literal["opengl", "warp"] = "opengl"
    """What draws the images: OpenGL, or MuJoCo Warp on a graphics card (extra gpu), which many sessions at once can
    share. Outlines and fine shading differ."""
    dynamics: Literal["mujoco", "closed_form"] = "mujoco"
    """How bodies get from frame to frame: in MuJoCo's physics, or as it comes out where nothing pushes: the caregiver's
    joints are where the script has them, and the head's servos follow their difference equation. Sessions from the
    state are faster then; the caregiver's head differs by some 1e-12 rad, the arm by 1e-8."""


def steps_per_frame(model: mujoco.MjModel) -> int:
    """Physics steps in one camera frame."""
    count: int = round(FRAME_S / model.opt.timestep)
    return count


AS_USUAL = Conditions()
"""The scene's own light and colours, and a camera without noise or delay."""


def build_physics(config: WorldConfig, conditions: Conditions = AS_USUAL) -> Physics:
    """dm_control's physics of the compiled scene; with textures, where ``conditions`` paint patterns on surfaces."""
    return RenderingPhysics.from_model(MjModel(build_model(config.scene, blank=conditions.surfaces.contrast > 0)))


def _new_eye(config: WorldConfig, physics: Physics) -> Eye:
    """The robot's eye, as ``config`` asks for it."""
    if config.renderer == "warp":
        return WarpEye(physics, config.scene, config.draws)
    return Eye(physics) if config.draws == "all" else RedrawingEye(physics)


class World(Closable):
    """A simulated world: bodies in a physics, moved by the caregiver's script and the robot's head servos.

    Attributes:
        config: Looks, behaviour, layout.
        conditions: Light, surfaces and camera.
        caregiver: The script, with the caregiver's phase and target, and the objects' positions.
        rendered_frames: How many images were rendered in this episode.
    """

    frames: int = 1
    """Camera frames of 1/30 s in a step, during which bodies move at constant speed; subclasses may have more."""

    def __init__(
        self, config: WorldConfig, physics: Physics, seed: np.random.SeedSequence, conditions: Conditions = AS_USUAL
    ):
        """Make a world and begin its first episode.

        Args:
            config: Looks, behaviour, layout.
            physics: What ``build_physics`` gives for ``config``.
            seed: Of the episode.
            conditions: Light, surfaces and camera.
        """
        self._bind(config, physics)
        self.vary(config, conditions)
        self.reset(seed)

    def __repr__(self) -> str:
        if self.closed:
            return f"{type(self).__name__}(closed)"
        scene = self.config.scene
        return f"{type(self).__name__}({scene.caregiver}, {len(scene.objects)} objects, {self.data.time:.2f} s)"

    def _bind(self, config: WorldConfig, physics: Physics) -> None:
        """Look up where in the physics joints and objects are."""
        self.config, self.physics = config, physics
        self.model = model = physics.model.ptr
        self.data = physics.data.ptr
        self.eye = _new_eye(config, physics)
        scripted, head = (_spans(model, names) for names in (SCRIPTED_JOINTS, HEAD_JOINTS))
        self._script_angles, self._script_speeds = self.data.qpos[scripted[0]], self.data.qvel[scripted[1]]
        self._face_angles = self._script_angles[:2]
        self._head_angles, self._head_speeds = self.data.qpos[head[0]], self.data.qvel[head[1]]
        self._head = head[0]
        objects = _span([model.body(f"object/{item.name}").mocapid[0] for item in config.scene.objects])
        self._object_positions = self.data.mocap_pos[objects]
        self._controls = self.data.ctrl
        self._servos = Servos.of_model(model)
        self._steps = self.frames * steps_per_frame(model)
        self._wardrobe: Wardrobe | None = None
        self._image: np.ndarray | None = None
        self._resting: mujoco.MjData | None = None  # all bodies as an episode begins, once ``script`` needs them

    @classmethod
    def build(cls, config: WorldConfig, seed: np.random.SeedSequence, conditions: Conditions = AS_USUAL) -> Self:
        """Make a world and its physics; for the arguments see the constructor."""
        return cls(config, build_physics(config, conditions), seed, conditions)

    def vary(self, config: WorldConfig, conditions: Conditions) -> None:
        """Change looks and behaviour from the next ``reset`` on, for example to what ``variation.drawn`` gives.

        Args:
            config: Looks, behaviour, layout. The caregiver's identity and the objects' names stay as compiled.
            conditions: Light, surfaces and camera.

        Raises:
            ConfigError: Looks or light are to change, and Warp draws, which has those of the compiled scene.
        """
        if config.renderer == "warp" and (
            config.scene != self.config.scene or replace(conditions, sensor=AS_USUAL.sensor) != AS_USUAL
        ):
            raise ConfigError(
                "`world.renderer` warp draws the scene as it was compiled; looks, surfaces and light that change need "
                "opengl"
            )
        if config is not self.config or conditions != AS_USUAL:
            self._wardrobe = self._wardrobe or Wardrobe(self.model)
        if self._wardrobe is not None:
            upload(self.physics, self._wardrobe.dress(config.scene, conditions))
        self.config, self.conditions = config, conditions
        self._past = Past(conditions.sensor.delay / self.frames)
        self.eye.forget()

    def reset(self, seed: np.random.SeedSequence) -> None:
        """Begin an episode: objects laid out anew, the caregiver about to greet, the robot's head straight ahead."""
        mujoco.mj_resetData(self.model, self.data)
        mujoco.mj_forward(self.model, self.data)
        self.caregiver = self._script(self.data, seed)
        self._script_angles[:] = self.caregiver.joints
        self._object_positions[:] = self.caregiver.objects
        mujoco.mj_forward(self.model, self.data)
        self._objects_before = self.caregiver.objects.copy()
        self._points = np.vstack([self.caregiver.objects, self.data.site("caregiver/face").xpos])
        self._past.forget()
        self.rendered_frames = 0
        self._image = None
        self.eye.forget()

    def script(self, seed: np.random.SeedSequence) -> TransferScript:
        """The caregiver's script of an episode, as ``reset`` begins it; the bodies stay as they are."""
        if self._resting is None:
            self._resting = mujoco.MjData(self.model)
            mujoco.mj_forward(self.model, self._resting)
        return self._script(self._resting, seed)

    def _script(self, resting: mujoco.MjData, seed: np.random.SeedSequence) -> TransferScript:
        arm = Arm.from_model(self.model, np.radians(self.config.behaviour.hand_pitch_deg))
        return self.new_caregiver(resting.site("caregiver/face").xpos.copy(), arm, np.random.default_rng(seed))

    def show(self, head: np.ndarray, script: TransferScript) -> None:
        """Put all bodies where another episode has them, for an image of it.

        Args:
            head: (2,) pan and tilt of the robot's head, rad.
            script: The caregiver's script in that episode.
        """
        self._head_angles[:], self._script_angles[:], self._object_positions[:] = head, script.joints, script.objects
        place(self.model, self.data)
        self._image = None

    def new_caregiver(self, head: np.ndarray, arm: Arm, rng: np.random.Generator) -> TransferScript:
        """The caregiver's script for an episode.

        Args:
            head: (3,) centre of the caregiver's head, world frame, metres.
            arm: The caregiver's arm.
            rng: The script's random numbers.
        """
        config = self.config
        objects, height = len(config.scene.objects), rest_height(config.scene)
        return TransferScript(config.behaviour, config.layout, objects, height, head, arm, rng)

    def step(self, command: np.ndarray) -> None:
        """Simulate one step, in which the head's servos follow ``command`` (2,), pan and tilt, rad."""
        self.before_step(command)
        if self.config.dynamics == "closed_form":
            self._script_angles[:] = self.caregiver.joints
            turn(self._servos, self._head_angles[None], self._head_speeds[None], self._controls[None], self._steps)
            self._place(self._steps)
            return
        mujoco.mj_step2(self.model, self.data)
        if self._steps > 1:
            mujoco.mj_step(self.model, self.data, self._steps - 1)
        mujoco.mj_step1(self.model, self.data)

    @property
    def runs(self) -> bool:
        """Whether ``run`` can be used.

        The caregiver plays plans, the camera has no delay, and MuJoCo's steps, if they are taken, are found and call no
        Python.
        """
        if self._steps != 1 or self.conditions.sensor.delay:
            return False
        if type(self.caregiver).advance is not TransferScript.advance:
            return False
        return self.config.dynamics == "closed_form" or (half_steps() is not None and not calls_python())

    def run(self, commands: np.ndarray) -> Tape:
        """Simulate a step for each of ``commands`` (k, 2), pan and tilt, rad, as ``step`` does it one by one.

        Returns:
            What was to be seen before each of these steps.

        Raises:
            ValueError: The commands have another shape, or MuJoCo's steps are not found.
        """
        halves = () if self.config.dynamics == "closed_form" else half_steps()
        if halves is None:
            raise ValueError("MuJoCo's steps are not found; ask ``runs`` before")
        before = self.caregiver.objects.copy()
        commands = np.ascontiguousarray(commands, float)
        if commands.shape[1:] != self._controls.shape:
            raise ValueError(f"expected commands (k, {len(self._controls)}), rad; got {commands.shape}")
        frames = len(commands)
        doing, joints = np.empty((frames, 3), np.int64), np.empty((frames, len(self._script_angles)))
        objects, (head, face, face_speeds) = np.empty((frames + 2, *before.shape)), np.empty((3, frames, 2))
        objects[0], objects[1] = self._objects_before, before
        self.caregiver.advance_all(doing, joints, objects[2:])
        self._objects_before[:] = objects[-2]
        given: tuple[Any, ...] = (
            commands, joints, objects[2:], FRAME_S, self._controls, self._script_angles, self._script_speeds,
            self._object_positions, self._head_angles[None], head, face, face_speeds,
        )  # fmt: skip
        if halves:
            run_in_physics(*halves, self.model._address, self.data._address, *given)
        else:
            run_closed_form(self._servos, self._head_speeds[None], *given)
            self._place(frames)
        self._image = None
        return Tape(doing, head, face, face_speeds, objects[:-1])

    def steps_to_rest(self, commands: np.ndarray, least: int) -> int:
        """How many steps the head takes before it stands still, if it is commanded so; with dynamics closed_form.

        Args:
            commands: (k, 2) desired pan and tilt, rad.
            least: So many steps at least, 0 to k.

        Returns:
            From ``least`` to k; k also where the head still moves then.
        """
        heads, speeds = self._head_angles[None], self._head_speeds[None]
        steps: int = steps_to_rest(self._servos, heads, speeds, commands, least, _HEAD_STILL)
        return steps

    def _place(self, steps: int) -> None:
        """Put all bodies where their joints are by now, so many steps of the physics later."""
        now, seconds = self.data.time, self._servos.seconds
        for _ in range(steps):  # as MuJoCo adds them up
            now += seconds
        self.data.time = now
        place(self.model, self.data)

    def now(self) -> Tape:
        """The present frame."""
        caregiver = self.caregiver
        angles, objects = np.empty((3, 1, 2)), np.empty((2, *caregiver.objects.shape))
        angles[0], angles[1], angles[2] = self._head_angles, self._face_angles, self._script_speeds[:2]
        objects[0], objects[1] = self._objects_before, caregiver.objects
        return Tape(np.array([caregiver.doing()]), angles[0], angles[1], angles[2], objects)

    def before_step(self, command: np.ndarray) -> None:
        """Prepare a step: advance the script, and set servos, the caregiver's joint velocities and the objects.

        The caregiver's joints have so much inertia that they keep these velocities, and reach the script's angles when
        the step ends.

        Args:
            command: (2,) desired pan and tilt of the head, rad.
        """
        caregiver = self.caregiver
        self._past.note(self.data)
        self._objects_before[:] = caregiver.objects
        for _ in range(self.frames):
            caregiver.advance()
        self._controls[:] = command
        set_out(
            caregiver.joints, self._script_angles, self._script_speeds, caregiver.objects, self._object_positions,
            self.frames * FRAME_S,
        )  # fmt: skip
        self._image = None

    def image(self) -> np.ndarray:
        """The image of the robot's eye now, uint8 (240, 320, 3) RGB; rendered at the first call in a frame."""
        if self._image is None:
            self._image = self._render()
            self.rendered_frames += 1
        return self._image

    def _render(self) -> np.ndarray:
        sensor = self.conditions.sensor
        if sensor.delay:
            with self._past.shown(self.model, self.data):
                image = self.eye.render()
        else:
            image = self.eye.render()
        if sensor != AS_USUAL.sensor:
            image = image.copy()
            sensor.expose(image, round(self.data.time / FRAME_S))
        return image

    def head_angles(self) -> np.ndarray:
        """Pan and tilt of the robot's head, (2,), rad; a new array."""
        angles: np.ndarray = self._head_angles.copy()
        return angles

    def head_angles_in_image(self) -> np.ndarray:
        """Pan and tilt, (2,), rad, that the robot's head had when the camera took what ``image`` shows; a new array."""
        if not self.conditions.sensor.delay:
            return self.head_angles()
        angles, _ = self._past.state(self.data)
        return np.array(angles[self._head])

    def head_velocity(self) -> np.ndarray:
        """Angular velocity of the robot's head, pan and tilt, (2,), rad/s; a new array."""
        speeds: np.ndarray = self._head_speeds.copy()
        return speeds

    def head_moves(self) -> bool:
        """Whether the robot's head turns, so that flow in the image is its own."""
        pan, tilt = self._head_speeds.tolist()
        moves: bool = max(abs(pan), abs(tilt)) > _HEAD_STILL
        return moves

    def face_angles(self) -> np.ndarray:
        """Yaw and pitch of the caregiver's head, (2,), rad; a view that changes with the next step."""
        angles: np.ndarray = self._face_angles
        return angles

    def face_angles_deg(self) -> np.ndarray:
        """Yaw and pitch of the caregiver's head, (2,), degrees; a new array."""
        angles: np.ndarray = np.degrees(self._face_angles)
        return angles

    def candidate_points(self) -> np.ndarray:
        """Centres of the n objects and, last, of the caregiver's head: (n + 1, 3), world frame, metres."""
        self._points[:-1] = self.caregiver.objects
        return self._points

    def moving(self, face_above_deg_s: float, object_above_m_s: float) -> np.ndarray:
        """Which candidates moved in the last frame: (n + 1,) bool.

        Args:
            face_above_deg_s: Speed above which the caregiver's head moves, degrees per second.
            object_above_m_s: Speed above which an object moves, metres per second.
        """
        moved = np.empty(len(self._objects_before) + 1, bool)
        note_moves(
            self.caregiver.objects, self._objects_before, self._script_speeds, radians(face_above_deg_s),
            (object_above_m_s * FRAME_S) ** 2, moved,
        )  # fmt: skip
        return moved

    def check(self) -> None:
        """Check that the simulation is stable.

        Raises:
            NotFiniteError: Joint angles or velocities are not finite, or MuJoCo has reset them because of that.
        """
        check_finite({"joint angles": self.data.qpos, "joint velocities": self.data.qvel, "controls": self.data.ctrl})
        if any(self.data.warning[kind].number for kind in UNSTABLE):
            raise NotFiniteError(
                "the simulation became unstable: some option of the caregiver's or the robot's movement is too large"
            )

    def close(self) -> None:
        """Free model, data and rendering context. Any use of the world afterwards raises ``ClosedError``."""
        if not self.closed:
            self.physics.free()
            self._shut()

    def __reduce_ex__(self, protocol: Any) -> Any:
        """A copy of a closed world is closed, so that results of finished runs can be copied."""
        return (closed_one, (type(self),)) if self.closed else super().__reduce_ex__(protocol)

    def get_state(self) -> dict[str, Any]:
        """Everything that the future depends on, as plain data, which nothing that happens later changes."""
        return {name: snapshot.take(value) for name, value in self.__getstate__().items()}

    def set_state(self, state: dict[str, Any]) -> None:
        """Go back to a state of this world, or of one with the same caregiver and objects; it can be used again."""
        config, conditions = state["config"], state["conditions"]
        if (config, conditions) != (self.config, self.conditions):
            self.vary(config, conditions)
        for name in state.keys() - {"integration", "config", "conditions", "eye"}:
            setattr(self, name, snapshot.put(getattr(self, name), state[name]))
        self._go_on_from(state["integration"], state["eye"])

    def __getstate__(self) -> dict[str, Any]:
        """Everything that the future depends on; the model is compiled again from the config."""
        integration = np.empty(mujoco.mj_stateSize(self.model, mujoco.mjtState.mjSTATE_INTEGRATION))
        mujoco.mj_getState(self.model, self.data, integration, mujoco.mjtState.mjSTATE_INTEGRATION)
        kept = ("config", "conditions", "caregiver", "rendered_frames", "_objects_before", "_points", "_past")
        eye = self.eye.get_state()
        return {"integration": integration, "eye": eye, **{name: getattr(self, name) for name in kept}}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a world.

        Raises:
            ValueError: Its physics is in no state that MuJoCo could go on from, or its objects are others than those
                of its scene.
        """
        state = dict(state)
        integration, eye = state.pop("integration"), state.pop("eye", {})
        most = mujoco.mjMAXVAL
        check_array("the state of the physics", integration, integration.shape, float, -most, most)
        config, conditions = state["config"], state["conditions"]
        self._bind(config, build_physics(config, conditions))
        self.vary(config, conditions)
        self.__dict__.update(state)
        shape = self._object_positions.shape
        check_array("the objects", self.caregiver.objects, shape, float)
        check_array("the objects before", self._objects_before, shape, float)
        check_array("the points", self._points, (shape[0] + 1, 3), float)
        self._go_on_from(integration, eye)

    def _go_on_from(self, integration: np.ndarray, eye: dict[str, Any]) -> None:
        """Take over positions and velocities (MuJoCo's integration state) and the eye's state of an equal world."""
        mujoco.mj_setState(self.model, self.data, integration, mujoco.mjtState.mjSTATE_INTEGRATION)
        mujoco.mj_step1(self.model, self.data)
        self.eye.set_state(eye)
        self._image = None


def _span(addresses: Sequence[int]) -> slice:
    """Consecutive addresses as a slice: numpy reads and writes through it without copying."""
    first, count = addresses[0], len(addresses)
    if list(addresses) != list(range(first, first + count)):
        raise ValueError(f"the scene must list these one after the other; got addresses {list(addresses)}")
    return slice(first, first + count)


def _spans(model: mujoco.MjModel, joints: Sequence[str]) -> tuple[slice, slice]:
    """Where the joints' angles and speeds lie in qpos and qvel."""
    named = [model.joint(name) for name in joints]
    return _span([joint.qposadr[0] for joint in named]), _span([joint.dofadr[0] for joint in named])


class WorldObservation:
    """What the robot may know of a simulated world as it is now (see ``perception.percept.Observation``)."""

    def __init__(self, world: World):
        self._world = world

    @property
    def image(self) -> np.ndarray:
        """The camera's image, uint8 (240, 320, 3) RGB; rendered at the first read in a frame, and only then."""
        return self._world.image()

    @property
    def head_angles(self) -> np.ndarray:
        """Pan and tilt of the robot's head, (2,), rad."""
        return self._world.head_angles()

    @property
    def head_moves(self) -> bool:
        """Whether the robot's head turns."""
        return self._world.head_moves()


class AlignedObservation(WorldObservation):
    """What a robot may know that has measured by how much its camera is late: its head as it was in the image."""

    @property
    def head_angles(self) -> np.ndarray:
        """Pan and tilt of the head when the image was taken, (2,), rad."""
        return self._world.head_angles_in_image()

    @property
    def head_moves(self) -> bool:
        """Whether the robot's head turns, or has come to rest so lately that the image does not show it yet."""
        world = self._world
        delay = world.conditions.sensor.delay
        if world.head_moves() or not delay:
            return world.head_moves()
        behind = np.abs(world.head_angles() - world.head_angles_in_image()).max()
        return bool(behind > _HEAD_STILL * delay * FRAME_S)
