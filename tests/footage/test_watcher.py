"""Who watches a video: when attention shifts, what repetitions do, and the fixations that come of it."""

import numpy as np
import pytest

from jointattn_mj.footage.fixations import MEANINGS, Fixations
from jointattn_mj.footage.frame_map import FrameMap
from jointattn_mj.footage.watcher import Watcher
from jointattn_mj.gaze_following.attention import AttentionConfig
from jointattn_mj.perception.percept import Percept

PERIOD = AttentionConfig.selection_period
IMAGE = np.zeros((240, 320, 3), np.uint8)
LOCATIONS = np.array([[50.0, 150.0], [250.0, 150.0], [160.0, 80.0]])


class Perceiver:
    """Sees two objects and a face, always in the same places; counts its looks."""

    def __init__(self, moves=(False, False, False)):
        self.looks: list[bool] = []
        self.passed = 0
        self.percept = Percept(np.ones(3, bool), LOCATIONS.copy(), np.array(moves))

    def perceive(self, observation, landed):
        assert observation.image.shape == (240, 320, 3)
        np.testing.assert_array_equal(observation.head_angles, [0, 0])
        self.looks.append(landed)
        return self.percept

    def pass_over(self, frames):
        self.passed += frames


def watcher(shift_frames=4, moves=(False, False, False), wants=None, **options) -> Watcher:
    watching = Watcher(Perceiver(moves), AttentionConfig(**options), 2, shift_frames, np.random.default_rng(0))
    if wants is not None:
        order = iter(wants)
        watching.attention.draw = lambda visible: next(order)
    return watching


def advance(watching: Watcher, frames: int) -> list[tuple[int | None, int | None]]:
    """What was attended, and where attention was going, frame by frame."""
    path = []
    for frame in range(frames):
        watching.see(IMAGE, True, frame == 0)
        path.append((watching.attended, watching.goal))
    return path


def test_a_draw_every_so_many_frames_of_dwell():
    before, first = [(None, None)] * (PERIOD - 1), [(None, 2)] * 4
    face = [(2, None)] * (2 * PERIOD - 1)  # the second draw is for where it looks already
    shift, red = [(2, 0)] * 4, [(0, None)] * (2 * PERIOD - 1)
    expected = [*before, *first, *face, *shift, *red, (0, 1)]
    assert advance(watcher(wants=[2, 2, 0, None, 1]), len(expected)) == expected


def test_interest_stands_still_while_attention_shifts():
    watching = watcher(shift_frames=10, moves=(True, False, False), wants=[0, 0])
    advance(watching, PERIOD)
    frozen = watching.attention.interest.copy(), watching.attention.motion.copy()
    advance(watching, 9)
    np.testing.assert_array_equal(watching.attention.interest, frozen[0])
    np.testing.assert_array_equal(watching.attention.motion, frozen[1])
    assert watching.attention.motion[0] == PERIOD
    advance(watching, 2)
    assert watching.attended == 0
    assert watching.attention.motion[0] > PERIOD


def test_shifts_at_once():
    path = advance(watcher(shift_frames=0, wants=[2, 0]), 2 * PERIOD)
    assert path == [(None, None)] * (PERIOD - 1) + [(2, None)] * PERIOD + [(0, None)]


def test_repetitions_are_not_looked_at():
    """But time goes on in them: what moved still does."""
    watching = watcher(moves=(False, True, False), wants=[2] * 9)
    for frame in range(30):
        watching.see(IMAGE, frame % 3 == 0, frame in (0, 15))
    assert watching.perceiver.looks == [k in (0, 5) for k in range(10)]
    assert watching.attention.motion[1] > 20
    assert watching.perceiver.passed == 20


def test_nothing_in_view_is_attended():
    watching = watcher()
    watching.perceiver.percept.visible[:] = False
    assert advance(watching, 100) == [(None, None)] * 100


def test_the_seed_decides():
    assert advance(watcher(), 300) == advance(watcher(), 300)
    assert {attended for attended, _ in advance(watcher(), 900)} >= {0, 1, 2}


def test_fixations():
    """From arrival to departure; shifts belong to none; means are over the frames in which the thing was seen."""
    fixations = Fixations()
    watching = watcher(wants=[2, 0, 0, 1], moves=(True, False, False))
    for frame in range(4 * PERIOD + 14):
        percept = watching.perceiver.percept
        percept.visible[0], percept.px[0] = frame % 2 == 0, LOCATIONS[0] if frame % 2 == 0 else np.nan
        watching.see(IMAGE, True, frame == 0)
        fixations.note(watching, frame, FrameMap.fitted(640, 480))
    table = fixations.table(("red", "green", "face"))
    assert table.column_names == list(MEANINGS)
    face, red, green = table.to_pylist()
    assert (face["candidate"], red["candidate"], green["candidate"]) == ("face", "red", "green")
    start = PERIOD + 3
    assert face["start_s"] == pytest.approx(start / 30)
    assert face["end_s"] == pytest.approx((start + PERIOD - 1) / 30)
    assert red["start_s"] == pytest.approx((start + PERIOD + 3) / 30)
    assert red["end_s"] - red["start_s"] == pytest.approx((2 * PERIOD - 1) / 30)
    assert (red["x_px"], red["y_px"]) == (50, 150)
    assert (red["video_x_px"], red["video_y_px"]) == (100.5, 300.5)
    assert red["visible"] == pytest.approx(0.5, abs=0.02)
    assert red["moving"] == 1
    assert (face["visible"], face["moving"]) == (1, 0)
    shares = fixations.shares(("red", "green", "face"))
    assert shares["red"] == {"fixations": 1, "seconds": round((2 * PERIOD - 1) / 30, 3)}


def test_no_fixations():
    table = Fixations().table(("red", "face"))
    assert table.num_rows == 0
    assert table.column_names == list(MEANINGS)
