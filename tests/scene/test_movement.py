"""Minimum-jerk profiles, gaze directions, and the arm's inverse kinematics held against MuJoCo's forward kinematics."""

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jointattn_mj.scene.model import build_model
from jointattn_mj.scene.movement import ARM_JOINTS, Arm, gaze_angles, minimum_jerk, path_between, rotation_to_zyx

MODEL = build_model()
DATA = mujoco.MjData(MODEL)
ARM = Arm.from_model(MODEL, hand_pitch=np.radians(27))
ARM_QPOS = [MODEL.joint(f"caregiver/{name}").qposadr[0] for name in ARM_JOINTS]

angle = st.floats(-np.pi, np.pi)
coordinate = st.floats(-1, 1)


def grasp_of(joints: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Grasp (3,), hand (3, 3) and elbow (3,), all in the caregiver's own frame, for arm joints (7,)."""
    DATA.qpos[ARM_QPOS] = joints
    mujoco.mj_kinematics(MODEL, DATA)
    stand = DATA.body("caregiver")
    frame = stand.xmat.reshape(3, 3)
    own = [
        frame.T @ (point - stand.xpos)
        for point in (DATA.site("caregiver/grasp").xpos, DATA.body("caregiver/elbow").xpos)
    ]
    return own[0], frame.T @ DATA.body("caregiver/wrist").xmat.reshape(3, 3), own[1]


@pytest.mark.parametrize("frames", [2, 21, 300])
def test_minimum_jerk_rises_to_exactly_one(frames):
    progress = minimum_jerk(frames)
    assert progress.shape == (frames,)
    assert progress[-1] == 1
    assert np.all(np.diff(progress) > 0)
    np.testing.assert_allclose(progress[:-1] + progress[-2::-1], 1, atol=1e-12)  # the second half mirrors the first


def test_minimum_jerk_begins_and_ends_at_rest():
    frames = 300
    progress = np.concatenate([[0.0], minimum_jerk(frames)])
    speed = np.diff(progress) * frames
    acceleration = np.diff(speed) * frames
    assert speed.max() == pytest.approx(15 / 8, rel=1e-3)  # the profile's known peak
    assert speed[[0, -1]].max() < 1e-3 * speed.max()
    assert np.abs(acceleration[[0, -1]]).max() < 0.06 * np.abs(acceleration).max()


@given(st.lists(coordinate, min_size=6, max_size=6), st.integers(2, 60), st.floats(0, 0.3))
def test_path_ends_where_it_should_and_rises_by_its_arch(ends, frames, arch):
    start, end = np.reshape(ends, (2, 3))
    path = path_between(start, end, frames, arch)
    straight = path_between(start, end, frames)
    np.testing.assert_allclose(path[-1], end, atol=1e-12)
    np.testing.assert_array_equal(path[:, :2], straight[:, :2])
    risen = path[:, 2] - straight[:, 2]
    assert np.all((risen > -1e-12) & (risen < arch + 1e-12))
    if frames % 2 == 0:
        assert risen[frames // 2 - 1] == pytest.approx(arch)


def test_arched_path_begins_and_ends_at_rest():
    path = path_between(np.zeros(3), np.array([0.3, 0.2, 0.1]), 300, arch=0.12)
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    assert steps[[0, -1]].max() < 0.01 * steps.max()


@given(st.lists(st.floats(0.1, 1), min_size=3, max_size=3), st.sampled_from([-1, 1]))
def test_gaze_angles_turn_the_nose_to_the_point(point, side):
    eye, point = np.array([0, 0, 1.08]), np.array(point) * [1, side, 1]
    yaw, pitch = gaze_angles(eye, point)
    nose = np.array([np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), -np.sin(pitch)])
    towards = (point - eye) / np.linalg.norm(point - eye)
    np.testing.assert_allclose(nose, towards, atol=1e-12)


@settings(deadline=None)  # the first call compiles
@given(angle, st.floats(-1.5, 1.5), angle)
def test_rotation_to_zyx_is_the_inverse_of_three_hinges(yaw, pitch, roll):
    def about(axis: int, by: float) -> np.ndarray:
        quat, matrix = np.zeros(4), np.zeros(9)
        mujoco.mju_axisAngle2Quat(quat, np.eye(3)[axis], by)
        mujoco.mju_quat2Mat(matrix, quat)
        return matrix.reshape(3, 3)

    rotation = about(2, yaw) @ about(1, pitch) @ about(0, roll)
    again = rotation_to_zyx(rotation)
    np.testing.assert_allclose(about(2, again[0]) @ about(1, again[1]) @ about(0, again[2]), rotation, atol=1e-9)


@settings(max_examples=300, deadline=None)  # the first call compiles
@given(st.floats(0.05, 0.72), angle, st.floats(-1.4, 1.4), st.floats(-1, 1))
def test_the_arm_reaches_every_point_within_its_length(distance, azimuth, elevation, swing):
    along = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
    point = ARM.shoulder + distance * along + ARM.hand @ ARM.grasp
    grasp, hand, elbow = grasp_of(ARM.reach(point[None], np.array([swing]))[0])
    assert np.linalg.norm(grasp - point) < 1e-6
    np.testing.assert_allclose(hand, ARM.hand, atol=1e-6)  # the hand keeps its orientation wherever it goes
    assert np.linalg.norm(elbow - ARM.shoulder) == pytest.approx(ARM.upper)


def test_swing_raises_the_elbow():
    point = np.array([[0.4, -0.1, 0.75]])
    heights = [grasp_of(ARM.reach(point, np.array([swing]))[0])[2][2] for swing in (-0.5, 0, 0.5)]
    assert heights[0] < heights[1] < heights[2]


def test_a_point_out_of_reach_is_approached_with_a_straight_arm():
    point = ARM.shoulder + np.array([2.0, 0.3, 0.1])
    joints = ARM.reach(point[None], np.zeros(1))[0]
    grasp, _, _ = grasp_of(joints)
    missing = np.linalg.norm(point - ARM.hand @ ARM.grasp - ARM.shoulder) - ARM.upper - ARM.fore
    assert np.linalg.norm(grasp - point) == pytest.approx(missing, abs=1e-4)
    assert abs(joints[3]) < 0.01
