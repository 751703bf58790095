"""Observations go into perception, percepts come out; both say in a line what they hold."""

import numpy as np
import pytest

from jointattn_mj.errors import ConfigError, ObservationError
from jointattn_mj.perception.faces import FaceFix
from jointattn_mj.perception.percept import Percept, StillObservation
from jointattn_mj.perception.pixels import PixelConfig, PixelPerception
from jointattn_mj.scene.objects import OBJECTS
from jointattn_mj.tasks import load


def perception() -> PixelPerception:
    return PixelPerception(PixelConfig(), np.array([item.rgb for item in OBJECTS[:4]]))


def test_lines():
    image, head = np.zeros((240, 320, 3), np.uint8), np.array([0.1, -0.2])
    line = "StillObservation(image=(240, 320, 3), pan=0.100 rad, tilt=-0.200 rad, head_moves=False)"
    assert repr(StillObservation(image, head)) == line
    percept = Percept(np.array([True, False, True]), np.zeros((3, 2)), np.array([False, False, True]))
    assert repr(percept) == "Percept(3 candidates, visible=[0, 2], moves=[2])"


@pytest.mark.parametrize("observation", [None, {}, "image", StillObservation(np.zeros((4, 4), np.uint8), np.zeros(2))])
def test_what_is_no_observation_is_refused(observation):
    with pytest.raises(ObservationError, match="image"):
        perception().perceive(observation, landed=True)


class Planned:
    """A face detector that answers with one planned position (x, y) after another, and tells where patches were cut."""

    reach_px = 30

    def __init__(self, *positions):
        self._positions, self.cut_at = iter(positions), []

    def detect(self, gray, expected_px, complete):
        x, y = next(self._positions)
        return FaceFix(x, y, 1.0, np.isfinite(x))

    def patch(self, gray, fix):
        self.cut_at.append((fix.x, fix.y))
        return np.zeros((32, 32), np.float32)

    def box(self, fix, shape):
        return 0, 0, 32, 32


@pytest.mark.parametrize(
    ("face_at", "expected"),
    [
        ("found", [(160, 120), (163, 119), (170, 120), (161, 121)]),
        ("remembered", [(160, 120), (160, 120), (170, 120), (160, 120)]),
    ],
)
def test_where_a_face_pattern_is_cut_out(face_at, expected):
    """At first there is nothing to remember; a face farther from there than is searched is not where the head was."""
    image = np.zeros((240, 320, 3), np.uint8)
    seen = PixelPerception(PixelConfig(), np.array([OBJECTS[0].rgb]), memory_rate=0.001, face_at=face_at)
    seen.faces = finder = Planned((160, 120), (163, 119), (170, 120), (161, 121), (np.nan, np.nan))
    for _ in expected:
        seen.perceive(StillObservation(image, np.zeros(2)), landed=True)
        assert seen.face_pattern().shape == (1024,)
    np.testing.assert_allclose(finder.cut_at, expected, atol=0.05)
    seen.perceive(StillObservation(image, np.zeros(2)), landed=True)
    with pytest.raises(ObservationError, match=r"no face|none"):
        seen.face_pattern()


def test_another_place_of_faces_is_refused():
    with pytest.raises(ConfigError, match=r"face_at: expected one of found, remembered; got 'remembred' \(perhaps"):
        PixelPerception(PixelConfig(), np.array([OBJECTS[0].rgb]), face_at="remembred")


class TestObservationsOfTasks:
    def test_one_without_an_image_says_what_there_is(self):
        environment = load("joint_attention", "follow", task_kwargs={"camera": False})
        observation = environment.reset().observation
        assert observation.head_angles is observation["head_angles"]
        with pytest.raises(ObservationError, match="expected an observation with camera; this task gives head_angles"):
            perception().perceive(observation, landed=True)
        with pytest.raises(ObservationError, match="head_moves"):
            _ = observation.head_moves
        environment.close()
