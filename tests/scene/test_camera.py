"""The eye: pinhole geometry held against itself, the MJCF, and rendered images."""

import cv2
import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jointattn_mj.errors import GLError
from jointattn_mj.scene.camera import (
    CENTRE_X,
    CENTRE_Y,
    FOVY_DEG,
    PIVOT,
    Eye,
    direction_of,
    directions_to,
    in_image,
    off_centre,
    pixel_of,
    pixels_of_points,
)
from jointattn_mj.scene.objects import OBJECTS
from jointattn_mj.scene.servo import HEAD_JOINTS
from jointattn_mj.scene.world import WorldConfig, build_physics

heads = st.tuples(st.floats(-45, 45), st.floats(-35, 15)).map(np.array)
pixels = st.tuples(st.floats(0, 319), st.floats(0, 239)).map(np.array)
points = st.tuples(st.floats(0.9, 1.5), st.floats(-0.4, 0.4), st.floats(0.7, 1.1)).map(np.array)


@pytest.fixture(scope="module")
def physics():
    physics = build_physics(WorldConfig())
    yield physics
    physics.free()


def turn(physics, head: np.ndarray) -> None:
    """Set the robot's head to pan and tilt, degrees."""
    physics.named.data.qpos[list(HEAD_JOINTS)] = np.radians(head)
    physics.forward()


@given(pixels, heads)
def test_pixel_and_direction_are_inverse(pixel, head):
    np.testing.assert_allclose(pixel_of(direction_of(pixel, head), head), pixel, atol=1e-6)


@given(points, st.tuples(st.floats(-20, 20), st.floats(-20, 10)).map(np.array))
def test_pixels_of_points_agree_with_directions(point, head):
    np.testing.assert_allclose(
        pixels_of_points(point[None], head)[0], pixel_of(directions_to(point[None])[0], head), atol=1e-6
    )


@given(points)
def test_a_point_looked_at_is_at_the_centre(point):
    head = directions_to(point[None])[0]
    np.testing.assert_allclose(pixels_of_points(point[None], head)[0], (CENTRE_X, CENTRE_Y), atol=1e-6)
    np.testing.assert_allclose(direction_of(np.array([CENTRE_X, CENTRE_Y]), head), head, atol=1e-9)
    assert off_centre(head, head) == 0


def test_signs():
    left_and_up = directions_to(np.array([[1.0, 0.2, 1.1]]))[0]
    assert left_and_up[0] > 0
    assert left_and_up[1] > 0
    x, y = pixel_of(left_and_up, np.zeros(2))
    assert x < CENTRE_X  # what is to the robot's left is left in the image
    assert y < CENTRE_Y
    assert off_centre(np.array([3.0, 4.0]), np.zeros(2)) == pytest.approx(5)


def test_in_image():
    inside = in_image(np.array([[0, 0], [319, 239], [-1, 5], [320, 5], [5, 240], [np.nan, 5]]))
    np.testing.assert_array_equal(inside, [True, True, False, False, False, False])


@given(heads)
def test_geometry_agrees_with_the_model(physics, head):
    turn(physics, head)
    camera = physics.model.name2id("robot/eye", "camera")
    assert physics.model.cam_fovy[camera] == FOVY_DEG
    np.testing.assert_allclose(physics.data.cam_xpos[camera], PIVOT, atol=1e-12)
    ahead = -physics.data.cam_xmat[camera].reshape(3, 3)[:, 2]
    np.testing.assert_allclose(directions_to((PIVOT + ahead)[None])[0], head, atol=1e-9)


@pytest.mark.parametrize("head", [(0, -5), (12, -12), (-15, -8), (5, 0)])
def test_objects_appear_where_the_geometry_says(physics, head):
    turn(physics, np.array(head, float))
    hsv = cv2.cvtColor(Eye(physics).render(), cv2.COLOR_RGB2HSV).astype(int)
    positions = np.array([physics.named.data.xpos[f"object/{item.name}"] for item in OBJECTS[:4]])
    expected = pixels_of_points(positions, np.array(head, float))
    checked = 0
    for item, pixel in zip(OBJECTS[:4], expected, strict=True):
        if not in_image(np.array([pixel - 15, pixel + 15])).all():
            continue
        hue = cv2.cvtColor(np.array([[item.rgb]], np.float32), cv2.COLOR_RGB2HSV)[0, 0, 0] / 2
        apart = np.abs((hsv[..., 0] - hue + 90) % 180 - 90)
        y, x = np.nonzero((apart < 8) & (hsv[..., 1] > 140))
        near = np.hypot(x - pixel[0], y - pixel[1]) < 25
        assert near.sum() > 100
        assert np.hypot(x[near].mean() - pixel[0], y[near].mean() - pixel[1]) < 1.5
        checked += 1
    assert checked >= 3


def test_every_look_fills_the_same_buffer(physics):
    turn(physics, np.zeros(2))
    eye = Eye(physics)
    first = eye.render()
    before = first.copy()
    assert first.shape == (240, 320, 3)
    assert first.dtype == np.uint8
    turn(physics, np.array([10.0, 0.0]))
    assert eye.render() is first
    assert not np.array_equal(first, before)


def test_a_image_is_a_function_of_the_state(physics):
    images = []
    for pan in (0.0, 8.0, 0.0):
        turn(physics, np.array([pan, -5.0]))
        images.append(Eye(physics).render().copy())
    np.testing.assert_array_equal(images[0], images[2])
    assert not np.array_equal(images[0], images[1])


def test_other_cameras_and_sizes(physics):
    assert Eye(physics, "third_person", 160, 120).render().shape == (120, 160, 3)


def test_without_rendering_the_error_says_what_to_do(physics, monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "disable")
    with pytest.raises(GLError, match="works here: leave MUJOCO_GL out"):
        Eye(physics.copy()).render()


def test_model_is_left_alone(physics):
    """Looking changes nothing in the state."""
    turn(physics, np.array([3.0, -4.0]))
    size = mujoco.mj_stateSize(physics.model.ptr, mujoco.mjtState.mjSTATE_INTEGRATION)
    before, after = np.empty(size), np.empty(size)
    mujoco.mj_getState(physics.model.ptr, physics.data.ptr, before, mujoco.mjtState.mjSTATE_INTEGRATION)
    Eye(physics).render()
    mujoco.mj_getState(physics.model.ptr, physics.data.ptr, after, mujoco.mjtState.mjSTATE_INTEGRATION)
    np.testing.assert_array_equal(before, after)
