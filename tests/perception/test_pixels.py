"""The pixel path: it gets an image and its own head angles, and nothing else."""

import subprocess
import sys

import numpy as np
import pytest

from jointattn_mj.errors import ObservationError
from jointattn_mj.gaze_following.agent import FamiliariseConfig, GazeFollower, RobotConfig
from jointattn_mj.perception.percept import StillObservation
from jointattn_mj.perception.pixels import PixelConfig, PixelPerception
from jointattn_mj.scene import gl
from jointattn_mj.scene.camera import pixels_of_points
from jointattn_mj.scene.world import World, WorldConfig

pytestmark = pytest.mark.integration

needs_gl = pytest.mark.skipif(not any(map(gl.available, gl.LIBRARIES)), reason="no OpenGL library to render with")
WORLD_SIDE = ("world", "caregiver", "movement", "layout")


def test_it_imports_nothing_of_the_world():
    """Nor of anything that knows it; checked in a fresh process, where nobody else has imported it."""
    code = "import sys, jointattn_mj.perception.pixels; print(*sorted(n for n in sys.modules if 'jointattn' in n))"
    names = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout.split()
    assert "jointattn_mj.perception.faces" in names
    assert not [name for name in names if name.split(".")[-1] in (*WORLD_SIDE, "state", "session", "scoring")]


def rgb(world: World) -> np.ndarray:
    return np.array([item.rgb for item in world.config.scene.objects])


@needs_gl
def test_percepts_lie_where_things_are():
    world = World.build(WorldConfig(), np.random.SeedSequence(5))
    perceiver = PixelPerception(PixelConfig(), rgb(world))
    off, moves = [], np.zeros(5)
    for frame in range(120):
        world.step(np.radians([0.0, -3.0]))
        if frame < 20:  # the head settles
            continue
        observation = StillObservation(world.image(), world.head_angles())
        percept = perceiver.perceive(observation, landed=frame == 20)
        assert percept.visible.all()
        off.append(percept.px - pixels_of_points(world.candidate_points(), np.degrees(world.head_angles())))
        moves += percept.moves
        assert frame > 20 or not percept.moves.any()
    off = np.median(np.linalg.norm(off, axis=2), axis=0)
    assert off[:-1].max() < 2.5  # px; a colour area's centre is not quite the object's
    assert off[-1] < 8
    assert moves[-1] > 5  # the caregiver has turned to an object
    pattern = perceiver.face_pattern()
    assert pattern.shape == (PixelPerception.pattern_size,)
    assert pattern.std() > 5
    world.close()


@needs_gl
def test_a_glance_has_no_motion():
    world = World.build(WorldConfig(), np.random.SeedSequence(5))
    looking, glancing = (PixelPerception(PixelConfig(), rgb(world)) for _ in range(2))
    for _ in range(30):
        world.step(np.radians([0.0, -3.0]))
        observation = StillObservation(world.image(), world.head_angles())
        percept, glance = looking.perceive(observation, landed=True), glancing.glance(observation)
        for name, values in vars(percept).items():
            np.testing.assert_array_equal(vars(glance)[name], values)
        assert glancing.fix == looking.fix
        assert glancing.motion is None
        assert not glance.moves.any()
    np.testing.assert_array_equal(glancing.face_pattern(), looking.face_pattern())
    world.step(np.radians([0.0, -3.0]))
    observation = StillObservation(world.image(), world.head_angles())
    assert not glancing.perceive(observation, landed=False).moves.any()  # no image to compare with
    world.close()


@needs_gl
def test_no_face_is_looked_for_beyond_a_part():
    world = World.build(WorldConfig(), np.random.SeedSequence(5))
    perceiver = PixelPerception(PixelConfig(), rgb(world))
    observation = StillObservation(world.image(), world.head_angles())
    x, y = perceiver.glance(observation).px[-1]
    reach = perceiver.faces.reach_px

    def seen(left, right, top=0, bottom=240):
        perceiver.narrow((left, top, right, bottom))
        return perceiver.glance(observation).visible

    assert seen(round(x - reach) - 1, 320).all()  # what the image's border cuts counts as whole
    assert seen(0, round(x + reach) + 1).all()
    for part in ((round(x), 320), (0, round(x)), (0, 320, round(y), 240), (0, 320, 0, round(y))):
        visible = seen(*part)
        assert visible[:-1].all() and not visible[-1]
        with pytest.raises(ObservationError):
            perceiver.face_pattern()
    world.close()


@needs_gl
def test_the_robot_needs_nothing_but_observations():
    """An image, the head's angles and one flag are enough."""
    world = World.build(WorldConfig(), np.random.SeedSequence(6))
    config = RobotConfig(familiarise=FamiliariseConfig(minutes=0.05))

    def observe() -> StillObservation:
        return StillObservation(world.image().copy(), world.head_angles(), world.head_moves())

    robot = GazeFollower(config, PixelPerception(PixelConfig(), rgb(world)), 4, np.random.SeedSequence(6))
    for frame in range(90):
        world.step(robot.familiarise(observe(), frame))
    assert robot.som.n_patterns == 30
    landed = []
    for _ in range(300):
        action = robot.act(observe())
        assert action.shape == (2,)
        assert np.abs(action).max() < 1
        world.step(action)
        if robot.landed is not None:
            landed.append(robot.landed)
    assert len(landed) >= 2
    assert any(shift.reached is not None for shift in landed)
    world.close()
