"""The session's video: what it shows, that it plays after a kill, and that it leaves the session alone."""

import os
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import cv2
import imageio_ffmpeg
import numpy as np
import pytest

from jointattn_mj.errors import VideoError
from jointattn_mj.gaze_following.agent import FamiliariseConfig, RobotConfig
from jointattn_mj.gaze_following.film import composer
from jointattn_mj.gaze_following.film.composer import Composer, verdict_in_words
from jointattn_mj.gaze_following.film.overlay import BAR, RobotsView
from jointattn_mj.gaze_following.film.panels import face_cells, lit
from jointattn_mj.gaze_following.film.video import Film
from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.gaze_following.shifts import ShiftRow
from jointattn_mj.gaze_following.summary import rate_of_success
from jointattn_mj.scene import gl
from jointattn_mj.video import paint
from jointattn_mj.video.onlooker import Onlooker, line_of_sight, sights
from jointattn_mj.video.percepts import caption

pytestmark = pytest.mark.integration

needs_gl = pytest.mark.skipif(not any(map(gl.available, gl.LIBRARIES)), reason="no OpenGL library to render with")
ROW = ShiftRow(
    launch_s=0, landing_s=0, source="face", chosen="blue", reached="red", commanded_by="learner",
    phase_at_launch="gaze",
    phase_at_landing="gaze", target_at_launch="red", target_at_landing="red", start_pan_deg=0, start_tilt_deg=0,
    command_pan_deg=0, command_tilt_deg=0, landing_pan_deg=0, landing_tilt_deg=0, learned=True, iterations=1,
    face_to_object=True, nearest="red", nearest_off_deg=1, on_nothing=False, success_at_launch=True,
    success_at_landing=True, success=True, pan_error_deg=0, tilt_error_deg=0, map_error_deg=0,
)  # fmt: skip


def config(perception: str) -> SessionConfig:
    robot = RobotConfig(familiarise=FamiliariseConfig(minutes=0.03))
    return SessionConfig(minutes=0.1, seed=1, perception=perception, robot=robot)


def frames_in(path: Path) -> np.ndarray:
    """Mean brightness of every image that can be decoded."""
    video, brightness = cv2.VideoCapture(str(path)), []
    while True:
        there, image = video.read()
        if not there:
            return np.array(brightness)
        assert image.shape == (720, 1280, 3)
        brightness.append(image.mean())


@needs_gl
@pytest.mark.parametrize(("perception", "every"), [("pixels", 1), ("state", 2)])
def test_film_changes_nothing(tmp_path, perception, every):
    frames = 51
    plain, filmed = SessionRun(config(perception)), SessionRun(config(perception))
    for session in (plain, filmed):
        session.begin()
    for _ in range(frames):
        plain.step()
    with Film(tmp_path / "video.mp4", filmed, every) as film:
        for _ in range(frames):
            filmed.step(film)
    assert plain.frames.table().equals(filmed.frames.table())
    assert plain.shifts == filmed.shifts
    for name, array in plain.weights().items():
        np.testing.assert_array_equal(array, filmed.weights()[name])
    np.testing.assert_array_equal(plain.world.data.qpos, filmed.world.data.qpos)
    assert plain.summary(1.0) == filmed.summary(1.0)
    shown = frames_in(tmp_path / "video.mp4")
    assert len(shown) == -(-frames // every)
    assert shown.min() > 20
    for session in (plain, filmed):
        session.close()


WRITER = """
import sys, time
from pathlib import Path
import numpy as np
from jointattn_mj.gaze_following.film import video
from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
class Stub:
    def __init__(self, session): self.image = np.random.default_rng(0).integers(0, 255, (720, 1280, 3), np.uint8)
    def compose(self, session): return np.roll(self.image, session.frame, 0)
    def close(self): pass
video.Composer = Stub
class Clock: frame = 0
clock = Clock()
with video.Film(Path(sys.argv[1]), clock) as film:
    while True:
        film(clock)
        clock.frame += 1
        if clock.frame == 120: print("written", flush=True)
"""


def test_video_plays_after_kill(tmp_path):
    """The writer and its ffmpeg are killed at once, without a chance to finish the file."""
    path = tmp_path / "video.mp4"
    with subprocess.Popen(
        [sys.executable, "-c", WRITER, str(path)], stdout=subprocess.PIPE, start_new_session=True
    ) as writer:
        assert writer.stdout is not None
        assert writer.stdout.readline() == b"written\n"
        os.killpg(writer.pid, signal.SIGKILL)
    assert writer.returncode == -signal.SIGKILL
    assert len(frames_in(path)) >= 30


def test_no_ffmpeg(tmp_path, monkeypatch):
    def nowhere() -> str:
        raise RuntimeError("No ffmpeg exe could be found.")

    monkeypatch.setattr("shutil.which", lambda name: None)
    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_exe", nowhere)
    session = SessionRun(config("state"))
    with pytest.raises(VideoError, match="apt-get install ffmpeg"), Film(tmp_path / "video.mp4", session):
        pass


def test_errors_of_ffmpeg_and_of_the_session(tmp_path, monkeypatch):
    """A dead ffmpeg is a named error, but does not hide what the session itself raises."""
    monkeypatch.setattr(Composer, "compose", lambda self, session: np.zeros((720, 1280, 3), np.uint8))
    session = SessionRun(config("state"))
    with pytest.raises(VideoError, match="stopped writing"), Film(tmp_path / "missing" / "a.mp4", session) as film:
        film(session)
    with pytest.raises(KeyboardInterrupt), Film(tmp_path / "missing" / "b.mp4", session) as film:
        film(session)
        raise KeyboardInterrupt


@needs_gl
def test_success_is_seen_at_a_glance():
    session = SessionRun(config("state"))
    session.begin()
    session.step()
    image = Composer(session)
    eye = composer._EYE
    edge = (eye.y - 3, slice(eye.x, eye.x + eye.width))
    assert (image.compose(session)[edge] == paint.GROUND).all()
    session.shifts.append(ROW)
    assert (image.compose(session)[edge] == paint.GREEN).all()
    session.shifts.append(replace(ROW, success=False, success_at_launch=False, success_at_landing=False))
    assert not (image.compose(session)[edge] == paint.GREEN).any()
    session.shifts.append(replace(ROW, landing_s=-composer.VERDICT_S))
    assert (image.compose(session)[edge] == paint.GROUND).all()
    image.close()
    session.close()


def test_verdict_in_words():
    assert verdict_in_words(ROW) == "Joint attention at red"
    just_there = replace(ROW, nearest="blue", success_at_landing=False)
    assert verdict_in_words(just_there) == "Joint attention: red was just there"
    missed = replace(ROW, nearest="blue", success=False)
    assert verdict_in_words(missed) == "Missed: robot at blue, person at red"
    assert verdict_in_words(replace(missed, on_nothing=True)) == "Missed: nothing is there"


def test_captions_stay_in_the_image():
    """Words at a border are moved inside, not cut off."""
    for top in ((-50.0, -50.0), (1000.0, 1000.0), (100.0, 60.0)):
        area = np.full((80, 300, 3), 255, np.uint8)
        caption(area, np.array(top), "learned guess", paint.LEARNED)
        dark = np.argwhere((area < 200).all(axis=2))
        assert np.ptp(dark, axis=0)[1] >= paint.width_of("learned guess", paint.TEXT) + 8


@needs_gl
def test_no_goal_is_drawn_under_the_line_of_text():
    """A goal below the image's upper part shines through nothing."""
    area = np.zeros((480 - BAR, 640, 3), np.uint8)
    RobotsView._draw_goal(area, np.array([0.0, -24.0]), np.zeros(2), paint.LEARNED, "goal")
    assert not area.any()
    RobotsView._draw_goal(area, np.array([0.0, -5.0]), np.zeros(2), paint.LEARNED, "goal")
    assert area.any()


def test_the_largest_text_that_fits():
    width = paint.width_of("joint attention", 18)
    assert paint.fitting("joint attention", width, (26, 22, 18, 15)) == 18
    assert paint.fitting("joint attention", 1, (26, 22)) == 22


@needs_gl
def test_the_light_of_an_onlooker_is_its_own():
    """It is brighter than the world's, and leaves that and the robot's image as they are."""
    world = SessionRun(config("state")).world
    before, light = world.image().copy(), world.model.light_diffuse.copy()
    onlooker = Onlooker(world, 592, 340)
    assert onlooker.render().mean() > 100
    np.testing.assert_array_equal(world.model.light_diffuse, light)
    np.testing.assert_array_equal(world.image(), before)
    onlooker.close()
    world.close()


@needs_gl
def test_what_moves_is_drawn_as_in_a_whole_view():
    """But for movements of a fifth of a pixel, of which some are drawn later."""
    world = SessionRun(config("state")).world
    views = [Onlooker(world, 592, 340) for _ in range(2)]
    for frame in range(60):
        world.step(np.radians([20.0 * (frame > 20), -10.0]))
        if frame % 3 == 0:
            views[1]._eye.forget()
            parts, whole = (view.render().astype(int) for view in views)
            assert (np.abs(parts - whole).max(axis=2) > 8).mean() < 2e-3
    for view in views:
        view.close()
    world.close()


def test_line_of_sight():
    things = np.array([(1.0, 0.0, 0.74), (1.0, 0.2, 0.74)])
    start = np.array([0.0, 0.0, 1.0])
    ahead = np.array([1.0, 0.0, -0.26]) / np.hypot(1, 0.26)
    sight = line_of_sight(start, ahead, things)
    assert sight.hit == 0
    np.testing.assert_allclose(sight.end, things[0], atol=1e-9)
    past = line_of_sight(start, np.array([0.8, 0.0, -0.6]), things)
    assert past.hit is None
    assert past.end[2] == pytest.approx(0.71)
    assert line_of_sight(start, np.array([-1.0, 0.0, 0.0]), things).hit is None


def test_both_look_at_each_other_at_first():
    """The caregiver greets the robot, whose head points straight ahead, to the pixel row of the face."""
    world = SessionRun(config("state")).world
    robot, person = sights(world)
    assert robot.hit == person.hit == len(world.caregiver.objects)
    world.close()


def test_rate_of_success():
    """Eq. 6.9: shifts at most a minute away count."""
    at, success = np.array([0.5, 1.5, 2.5]), np.array([True, False, True])
    np.testing.assert_allclose(rate_of_success(np.array([0.0, 1.0, 2.0, 9.0]), at, success), [1, 0.5, 0.5, np.nan])
    assert np.isnan(rate_of_success(np.arange(3.0), at[:0], success[:0])).all()


def test_map_is_brightest_where_it_is_active():
    som = SessionRun(config("state")).robot.som
    cells = face_cells(som, 180)
    activations = np.full(81, 1e-3)
    activations[9 * 2 + 5] = 1
    image = lit(cells, activations, (9, 9)).astype(float).sum(axis=2)
    bright = image.reshape(9, 20, 9, 20).mean(axis=(1, 3))
    assert np.unravel_index(bright.argmax(), bright.shape) == (2, 5)


def test_ink():
    for rgb in ((0, 0, 1), (0.1, 0, 0), (1, 1, 0)):
        ink = paint.ink_of(rgb)
        assert np.dot(ink, (0.2126, 0.7152, 0.0722)) >= 115
        assert max(rgb) == 0.1 or int(np.argmax(ink)) == int(np.argmax(rgb))
    image = np.zeros((30, 60, 3), np.uint8)
    for location in ((-20, -5), (55, 25), (200, 5), (-500, 0), (5, 100)):  # partly or wholly outside
        paint.write(image, *location, "joint")
    assert image.any()
    plain = np.zeros((40, 200, 3), np.uint8)
    end = paint.write(plain, 10, 5, "joint", (255, 0, 0))
    assert end == 10 + paint.width_of("joint")
    assert plain[..., 0].max() > 250
    assert not plain[..., 1:].any()
    assert not plain[:, end:].any()
