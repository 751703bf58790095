"""The scene has what everything else relies on: names, frames, joints that hold what is set, colours that differ."""

import colorsys

import mujoco
import numpy as np
import pytest

from jointattn_mj.errors import ConfigError
from jointattn_mj.scene.face import IDENTITIES
from jointattn_mj.scene.model import (
    HEAD_POSITION,
    IMAGE_HEIGHT,
    IMAGE_WIDTH,
    TABLE_Z,
    SceneConfig,
    build_model,
    rest_positions,
)
from jointattn_mj.scene.objects import OBJECTS, ObjectConfig

ARM = ("shoulder_yaw", "shoulder_pitch", "shoulder_roll", "elbow", "wrist_yaw", "wrist_pitch", "wrist_roll")
NECK = ("neck_yaw", "neck_pitch", "eye_left_yaw", "eye_left_pitch", "eye_right_yaw", "eye_right_pitch")


@pytest.fixture(scope="module")
def model():
    return build_model()


@pytest.fixture
def data(model):
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return data


def image(model, data, camera="robot/eye"):
    with mujoco.Renderer(model, IMAGE_HEIGHT, IMAGE_WIDTH) as renderer:
        renderer.update_scene(data, camera)
        return renderer.render().copy()


def test_agreed_names_exist(model):
    for joint in [f"caregiver/{name}" for name in NECK + ARM] + ["robot/pan", "robot/tilt"]:
        assert model.joint(joint).type[0] == mujoco.mjtJoint.mjJNT_HINGE
    for body in ("caregiver", "caregiver/shoulder", "caregiver/elbow", "caregiver/wrist", "robot/pan", "robot/tilt"):
        model.body(body)
    for o in OBJECTS[:4]:
        assert model.body(f"object/{o.name}").mocapid[0] >= 0
    for site in ("caregiver/face", "caregiver/grasp"):
        model.site(site)
    assert model.camera("robot/eye").fovy[0] == 48.5
    model.camera("third_person")
    assert model.opt.timestep == pytest.approx(1 / 30)
    assert not model.geom_contype.any() and not model.geom_conaffinity.any()


def test_places_of_head_camera_and_objects(model, data):
    np.testing.assert_allclose(data.site("caregiver/face").xpos, HEAD_POSITION, atol=1e-9)
    np.testing.assert_allclose(data.site("caregiver/face").xmat.reshape(3, 3)[:, 0], (-1, 0, 0), atol=1e-9)
    np.testing.assert_allclose(data.camera("robot/eye").xpos, (0, 0, 1.0), atol=1e-9)
    np.testing.assert_allclose(-data.camera("robot/eye").xmat.reshape(3, 3)[:, 2], (1, 0, 0), atol=1e-9)
    for o, position in zip(OBJECTS[:4], rest_positions(SceneConfig()), strict=True):
        np.testing.assert_allclose(data.body(f"object/{o.name}").xpos, position)
        assert position[2] == pytest.approx(TABLE_Z + 0.031)


def test_signs_of_angles(model, data):
    data.joint("robot/pan").qpos, data.joint("robot/tilt").qpos = 0.3, 0.2
    data.joint("caregiver/neck_yaw").qpos, data.joint("caregiver/neck_pitch").qpos = 0.3, 0.2
    mujoco.mj_forward(model, data)
    ahead = -data.camera("robot/eye").xmat.reshape(3, 3)[:, 2]
    assert ahead[1] > 0 and ahead[2] > 0  # to the robot's left, and up
    nose = data.site("caregiver/face").xmat.reshape(3, 3)[:, 0]
    assert nose[1] < 0 and nose[2] < 0  # to the left of the caregiver, and down
    np.testing.assert_allclose(data.site("caregiver/face").xpos, HEAD_POSITION, atol=1e-9)  # turns in place


def test_robot_head_settles_without_overshoot(model):
    data = mujoco.MjData(model)
    data.ctrl[model.actuator("robot/pan").id] = 0.4
    data.ctrl[model.actuator("robot/tilt").id] = -0.3
    pan, tilt = [], []
    for _ in range(12):
        mujoco.mj_step(model, data)
        pan.append(data.joint("robot/pan").qpos[0])
        tilt.append(data.joint("robot/tilt").qpos[0])
    assert max(pan) <= 0.4 + 1e-6 and min(tilt) >= -0.3 - 1e-6
    assert pan[2] > 0.95 * 0.4 and tilt[2] < 0.95 * -0.3  # after a tenth of a second
    assert pan[-1] == pytest.approx(0.4, abs=1e-3)


def test_scripted_joints_keep_the_velocity_that_was_set(model):
    data = mujoco.MjData(model)
    speed = {f"caregiver/{name}": 0.2 + 0.05 * k for k, name in enumerate(NECK + ARM)}
    for joint, value in speed.items():
        data.joint(joint).qvel = value
    data.ctrl[:] = 0.3
    for _ in range(15):
        mujoco.mj_step(model, data)
    for joint, value in speed.items():
        assert data.joint(joint).qpos[0] == pytest.approx(value * 0.5, abs=1e-3)


def test_arm_is_long_enough(model):
    """The grasp reaches every position of an object with the hand pitched down by 20 to 40 degrees."""
    shoulder = model.body("caregiver/shoulder").pos
    reach = model.body("caregiver/elbow").pos[0] + model.body("caregiver/wrist").pos[0]
    grasp = model.site("caregiver/grasp").pos
    for pitch in np.radians((20, 30, 40)):
        turn = np.array([[np.cos(pitch), 0, np.sin(pitch)], [0, 1, 0], [-np.sin(pitch), 0, np.cos(pitch)]])
        for x in (0.90, 1.12, 1.20):
            for y in (-0.36, 0.0, 0.36):
                position = np.array([1.5 - x, -y, 0.745]) if x < 1.2 else np.array([0.3, 0.0, 0.895])
                assert np.linalg.norm(position - turn @ grasp - shoulder) < reach


def test_building_is_deterministic_and_quality_changes_only_looks(model):
    again, high = build_model(), build_model(SceneConfig(quality="high"))
    np.testing.assert_array_equal(model.mesh_vert, again.mesh_vert)
    np.testing.assert_array_equal(model.tex_data, again.tex_data)
    for field in ("body_pos", "body_mass", "body_inertia", "jnt_axis", "jnt_pos", "dof_armature", "site_pos"):
        np.testing.assert_array_equal(getattr(model, field), getattr(high, field))
    assert high.vis.global_.offwidth >= 1280 and model.vis.global_.offwidth == IMAGE_WIDTH


def test_ten_objects_stand_apart_in_place_and_hue():
    config = SceneConfig(objects=OBJECTS)
    positions = rest_positions(config)[:, :2]
    gaps = np.linalg.norm(positions[:, None] - positions[None], axis=2) + np.eye(10)
    assert gaps.min() >= 0.13
    hues = np.sort([colorsys.rgb_to_hsv(*o.rgb)[0] * 360 for o in OBJECTS])
    assert np.diff(np.append(hues, hues[0] + 360)).min() >= 25
    assert build_model(config).nmocap == len(OBJECTS) + 1  # and the robot's forearm


@pytest.mark.parametrize("name", list(IDENTITIES))
def test_nothing_but_objects_has_saturated_colour(name):
    model = build_model(SceneConfig(caregiver=name))
    data = mujoco.MjData(model)
    data.joint("robot/tilt").qpos = -0.15
    data.joint("caregiver/neck_yaw").qpos = 0.4
    mujoco.mj_forward(model, data)
    with mujoco.Renderer(model, IMAGE_HEIGHT, IMAGE_WIDTH) as renderer:
        renderer.update_scene(data, "robot/eye")
        rgb = renderer.render().astype(float) / 255
        renderer.enable_segmentation_rendering()
        renderer.update_scene(data, "robot/eye")
        geom = renderer.render()[..., 0]
    bright = rgb.max(axis=2) > 0.2
    saturation = 1 - rgb.min(axis=2) / np.maximum(rgb.max(axis=2), 1e-9)
    things = np.isin(geom, [model.geom(f"object/{o.name}").id for o in OBJECTS[:4]])
    assert things.sum() > 4 * 100
    assert saturation[things & bright].min() > 0.8
    assert saturation[~things & bright].max() < 0.65


def test_third_person_sees_both(model, data):
    with mujoco.Renderer(model, IMAGE_HEIGHT, IMAGE_WIDTH) as renderer:
        option = mujoco.MjvOption()
        option.geomgroup[3] = 1
        renderer.enable_segmentation_rendering()
        renderer.update_scene(data, "third_person", scene_option=option)
        visible = np.unique(renderer.render()[..., 0])
    names = [f"object/{o.name}" for o in OBJECTS[:4]]
    for geom in ["robot/skull", "room/top", "caregiver/head", "caregiver/trunk", *names]:
        assert model.geom(geom).id in visible, geom


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"caregiver": "nobody"}, "nobody"),
        ({"quality": "best"}, "best"),
        ({"objects": (OBJECTS[0], OBJECTS[0])}, "distinct"),
        ({"objects": ()}, "objects: expected one at least"),
        ({"object_size": 0.5}, "object_size"),
    ],
)
def test_bad_configurations_are_named(options, says):
    with pytest.raises(ConfigError, match=says):
        SceneConfig(**options)


@pytest.mark.parametrize(("rgb", "shape", "says"), [((1, 0, 0), "torus", "torus"), ((2, 0, 0), "box", r"rgb.*\(2, 0")])
def test_bad_objects_are_named(rgb, shape, says):
    with pytest.raises(ConfigError, match=says):
        ObjectConfig("red", rgb, shape)
