"""Flow to a fraction of a pixel; what moves is told from what does not, also when something passes before it."""

import pickle

import numpy as np
import pytest
from stage import Stage, minimum_jerk

from jointattn_mj.errors import ConfigError
from jointattn_mj.perception.motion import MotionConfig, MotionDetector
from jointattn_mj.perception.objects import Areas, ColourAreas
from jointattn_mj.scene.objects import OBJECTS

RGB = np.array([o.rgb for o in OBJECTS[:4]])
NOTHING = Areas.empty(0, 22)
FACE = (100, 60, 132, 92)


def texture(dx=0.0, dy=0.0):
    """A smooth pattern moved by a fraction of a pixel, (240, 320) uint8."""
    y, x = np.mgrid[:240, :320].astype(float)
    x, y = x - dx, y - dy
    waves = np.sin(x / 4.1) * np.cos(y / 4.7) + 0.6 * np.sin(x / 7.7 + y / 9.3) + 0.5 * np.cos(x / 8.9 - y / 6.9)
    return np.round(128 + 50 * waves).astype(np.uint8)


@pytest.fixture(scope="module")
def stage():
    stage = Stage()
    yield stage
    stage.close()


@pytest.mark.parametrize("shift", [(0.1, 0.0), (0.0, -0.3), (0.45, 0.25), (1.4, -0.8), (-3.2, 2.6), (5.5, 0.0)])
def test_flow_is_exact_to_a_fraction_of_a_pixel(shift):
    detector = MotionDetector()
    for k in range(3):
        motion = detector.update(texture(shift[0] * k / 2, shift[1] * k / 2), FACE, NOTHING)
    assert len(motion.flow) > 10
    assert np.median(motion.flow, axis=0) == pytest.approx(shift, abs=0.12), "axes apart: slanted stripes mix them"
    assert motion.face_moves


def test_equal_images_have_no_flow_at_all():
    detector = MotionDetector()
    rng = np.random.default_rng(0)
    image = rng.integers(0, 256, (240, 320), dtype=np.uint8)
    for k in range(4):
        image[FACE[1], FACE[0]] = k  # in the rim that is left out: else nothing would be measured at all
        motion = detector.update(image.copy(), FACE, NOTHING)
    assert len(motion.flow) > 10 and not motion.flow.any() and not motion.face_moves


def test_nothing_moves_in_the_first_image_and_after_a_reset():
    detector = MotionDetector()
    assert not detector.update(texture(0), FACE, NOTHING).face_moves
    assert detector.update(texture(0.2), FACE, NOTHING).face_moves, "one frame back, scaled"
    detector.reset()
    assert not detector.update(texture(40), FACE, NOTHING).face_moves, "the robot's own turn was taken for motion"
    assert not detector.update(texture(40), FACE, NOTHING).face_moves


def test_the_face_region_stays_through_a_fixation():
    detector = MotionDetector()
    detector.update(texture(), (100, 60, 132, 92), NOTHING)
    first = detector.update(texture(0.5), (103, 61, 135, 93), NOTHING).blocks.copy()
    detector.reset()
    detector.update(texture(), (100, 60, 132, 92), NOTHING)
    assert (detector.update(texture(0.5), (100, 60, 132, 92), NOTHING).blocks == first).all()
    for k in range(3):
        found_elsewhere = detector.update(texture(k), (200, 60, 232, 92), NOTHING).blocks
    assert found_elsewhere[:, 0].min() > 190


def test_flag_stays_on_above_its_lower_threshold_and_lingers():
    config = MotionConfig(frames_back=1, face_px=0.2, stay_ratio=0.5, linger_frames=1)
    detector, shift, flags = MotionDetector(config), 0.0, []
    for step in (0.0, 0.15, 0.3, 0.15, 0.0, 0.0):
        shift += step
        flags.append(detector.update(texture(shift), FACE, NOTHING).face_moves)
    assert flags == [False, False, True, True, True, False]


@pytest.mark.parametrize("frames", [1, 2, 3, 6])
def test_a_slow_video_shows_the_same_motion(frames):
    """Images some frames apart: what moves is told by its speed, not by how far it comes from image to image."""
    for speed, moves in ((0.04, False), (0.08, True)):
        detector, flags = MotionDetector(MotionConfig(face_px=0.12)), []
        for k in range(6):
            detector.pass_over(frames - 1)
            motion = detector.update(texture(speed * frames * k), FACE, NOTHING)
            flags.append(motion.face_moves)
        assert flags == [False] + [moves] * 5
        assert motion.strength[-1] == pytest.approx(2 * speed, abs=0.02)


def run(stage, frames, pose):
    """Pose, image, motion: per frame the flags and whether the robot sees what moves."""
    finder, detector, flags = ColourAreas(RGB), MotionDetector(), []
    centre = stage.face_px()
    box = tuple(round(c) for c in (centre[0] - 16, centre[1] - 14, centre[0] + 16, centre[1] + 18))
    for k in range(frames):
        pose(k)
        gray, areas = finder.segment(stage.image())
        motion = detector.update(gray, box, areas)
        flags.append([*motion.object_moves, motion.face_moves])
    return np.array(flags)


@pytest.mark.parametrize(("start", "end"), [((0, 0), (-25, 25)), ((-25, 25), (20, 30)), ((0, 27), (12, 30))])
def test_a_head_turn_is_seen_from_its_start_to_its_end(stage, start, end):
    stage.look_from(0, 3)
    progress = np.concatenate([np.zeros(10), minimum_jerk(21), np.ones(10)])
    speed = np.hypot(*np.subtract(end, start)) * np.diff(progress, prepend=0) * 30
    flags = run(stage, len(progress), lambda k: stage.turn_face(*(start + progress[k] * np.subtract(end, start))))
    assert flags[speed > 4, 4].mean() > 0.85
    assert not flags[:10, 4].any() and not flags[-7:, 4].any() and not flags[:, :4].any()


@pytest.mark.parametrize("speed", [0.1, 0.3])
@pytest.mark.parametrize("eye", [(0, 3), (4, -14)])
def test_a_carried_object_moves_and_the_others_do_not(stage, eye, speed):
    stage.look_from(*eye)
    stage.turn_face(0, 27)
    start = np.array([1.05, 0.15, 0.80])

    def pose(k):
        path = speed / 30 * max(0, k - 5) if k < 20 else speed / 30 * 15
        stage.put(OBJECTS[1].name, tuple(start + np.array([0.2, -0.9, 0.4]) * path))

    flags = run(stage, 30, pose)
    assert flags[7:20, 1].all() and not flags[:5, 1].any() and not flags[23:, 1].any()
    assert not flags[:, [0, 2, 3, 4]].any()
    stage.put(OBJECTS[1].name, tuple(start))


def test_a_wobble_in_the_hand_is_motion(stage):
    stage.look_from(0, 3)

    def pose(k):
        stage.put(OBJECTS[0].name, (1.20, 0.015 * np.sin(2 * np.pi * 2 * k / 30), 0.895))

    flags = run(stage, 60, pose)
    assert flags[3:, 0].mean() > 0.8, "turning points last a frame or two"
    assert not flags[:, 1:].any()


def test_what_passes_before_or_behind_an_object_does_not_move_it(stage):
    stage.look_from(0, -5)
    stage.turn_face(0, 27)
    still, passing = np.array([1.0, 0.0, 0.741]), OBJECTS[2].name
    stage.put(OBJECTS[0].name, tuple(still))
    for depth in (-0.1, 0.1):

        def pose(k, depth=depth):
            stage.put(passing, (1.0 + depth, 0.2 - 0.013 * k, 0.76))

        flags = run(stage, 32, pose)
        assert flags[5:, 2].mean() > 0.7
        assert flags[:, 0].mean() < 0.1, depth


def test_pickled_halfway_it_goes_on_alike():
    whole, half = MotionDetector(), MotionDetector()
    images = [texture(0.07 * k * k) for k in range(8)]
    answers = [whole.update(image, FACE, NOTHING).flow.copy() for image in images]
    for k, image in enumerate(images):
        if k == 4:
            half = pickle.loads(pickle.dumps(half))
        assert (half.update(image, FACE, NOTHING).flow == answers[k]).all()


def test_impossible_options_are_refused():
    with pytest.raises(ConfigError, match="frames_back"):
        MotionConfig(frames_back=0)
    with pytest.raises(ConfigError, match="texture"):
        MotionConfig(texture=0.0)  # a flat block has no vertex
