"""Domain randomisation in the suite: every task takes it, a seed decides all, off is as ever, faces are found."""

import cv2
import numpy as np
import pytest

from jointattn_mj.errors import ConfigError
from jointattn_mj.perception.faces import FaceDetectorConfig, haar_faces
from jointattn_mj.perception.objects import ColourAreas
from jointattn_mj.scene.camera import pixels_of_points
from jointattn_mj.scene.objects import OBJECTS
from jointattn_mj.scene.variation import VariationConfig
from jointattn_mj.tasks import ALL_TASKS, load

pytestmark = pytest.mark.integration

every_task = pytest.mark.parametrize(("domain", "task"), ALL_TASKS, ids=lambda name: name)


def images(task: str, episodes: int = 2, **settings) -> list[np.ndarray]:
    """The first three images of some episodes."""
    environment = load("joint_attention", task, task_kwargs={"random": 6, **settings})
    idle = np.zeros(2, environment.action_spec().dtype)
    taken = []
    for _ in range(episodes):
        steps = [environment.reset(), environment.step(idle), environment.step(idle)]
        taken += [step.observation["camera"] for step in steps]
    environment.close()
    return taken


@every_task
def test_same_seed_same_images(domain, task):
    np.testing.assert_array_equal(images(task, variation="all"), images(task, variation="all"))


@every_task
def test_off_is_as_ever(domain, task):
    usual = images(task)
    np.testing.assert_array_equal(usual, images(task, variation="none"))
    varied = images(task, variation=VariationConfig(light_strength=0.4, camera_noise=5))
    assert all(np.abs(a.astype(int) - b).mean() > 2 for a, b in zip(usual, varied, strict=True))


def test_people_vary_and_models_are_compiled_once_a_person():
    environment = load("joint_attention", "follow", task_kwargs={"random": 1, "variation": "all", "camera": False})
    people, models = [], set()
    for _ in range(20):
        environment.reset()
        people.append(environment.task.world.config.scene.caregiver)
        models.add(id(environment.task.world.model))
    assert 3 < len(models) == len(set(people)) <= 6
    environment.close()


def test_one_thing_varies_and_all_else_goes_on_as_it_would_have():
    """Light and camera have no influence on what happens."""
    runs = []
    for variation in ("none", "lights+camera+textures"):
        environment = load(
            "joint_attention", "object_transfer", task_kwargs={"random": 2, "variation": variation, "camera": False}
        )
        for _ in range(2):
            environment.reset()
            for _ in range(50):
                environment.step(np.array([0.1, -0.1]))
        runs.append(environment.physics.get_state())
        environment.close()
    np.testing.assert_array_equal(*runs)


def test_pace_is_the_caregivers():
    environment = load("joint_attention", "follow", task_kwargs={"variation": VariationConfig(pace=0.5), "random": 3})
    visible = set()
    for _ in range(4):
        environment.reset()
        visible.add(environment.task.world.caregiver.config.gaze_s)
    assert len(visible) == 4
    environment.close()


def test_objects_of_the_turns_stand_on_the_table():
    settings = {"variation": "objects", "camera": False, "random": 0}
    environment = load("joint_attention", "turn_taking", task_kwargs=settings)
    for _ in range(3):
        environment.reset()
        heights, size = environment.physics.object_positions()[:, 2], environment.task.world.config.scene.object_size
        assert size != 0.06
        np.testing.assert_allclose(heights[heights > 0] - size / 2, 0.711, atol=1e-9)
    environment.close()


def test_unknown_presets_are_errors_that_tell_the_known_ones():
    with pytest.raises(ConfigError, match="lights"):
        load("joint_attention", "follow", task_kwargs={"variation": "weather"})


def test_face_and_objects_are_found_under_moderate_variation():
    """In 59 of 60 draws, and all objects, when ranges were chosen; here in the first 20 of other seeds."""
    environment = load("joint_attention", "object_transfer", task_kwargs={"random": 2024, "variation": "all"})
    colours = ColourAreas([item.rgb for item in OBJECTS[:4]])
    faces = objects = 0
    for _ in range(20):
        environment.reset()
        for _ in range(12):
            step = environment.step(np.zeros(2))
        image, world = step.observation["camera"], environment.task.world
        truth = pixels_of_points(world.candidate_points(), np.degrees(world.head_angles()))
        found = haar_faces(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), FaceDetectorConfig())
        faces += len(found) > 0 and np.linalg.norm(found[0, :2] - truth[-1]) < 10
        areas = colours.nothing()
        colours.find(image, np.empty(image.shape[:2], np.uint8), areas)
        objects += np.count_nonzero(np.linalg.norm(areas.px - truth[:-1], axis=1) < 8)
    environment.close()
    assert faces >= 18
    assert objects >= 76
