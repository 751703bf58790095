"""Objects in footage: several of a colour, picked ones, and what is none; motion against rest; cuts and cameras."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from clips import DETECTOR, Clip, counted, encode

from jointattn_mj.errors import ConfigError, FootageError
from jointattn_mj.footage.areas import AreaConfig, FootageAreas
from jointattn_mj.footage.colours import candidate_names, sought_objects
from jointattn_mj.footage.config import PerceiveConfig
from jointattn_mj.footage.followed import FollowedFace
from jointattn_mj.footage.frame_map import FrameMap
from jointattn_mj.footage.labels import label_table
from jointattn_mj.footage.people import Sighting
from jointattn_mj.footage.perception_config import FOR_CAMERAS
from jointattn_mj.footage.picked import colours_at
from jointattn_mj.footage.reader import RATE, Footage
from jointattn_mj.footage.rest import Rest, RestConfig
from jointattn_mj.footage.run import percepts
from jointattn_mj.footage.shots import ShotConfig, Shots
from jointattn_mj.footage.spans import Spans, write_spans
from jointattn_mj.footage.summary import notes
from jointattn_mj.footage.viewing import Viewing
from jointattn_mj.perception.motion import MotionDetector
from jointattn_mj.perception.objects import Areas, ColourConfig
from jointattn_mj.scene import gl

needs_gl = pytest.mark.skipif(not any(map(gl.available, gl.LIBRARIES)), reason="no OpenGL library to render with")
BLUE = (30, 60, 220)


def table(*things: tuple[int, int, int, int, tuple[int, int, int]]) -> np.ndarray:
    """An image (240, 320, 3) RGB with rectangles x, y, width, height, colour, on pale wood."""
    image = np.full((240, 320, 3), (200, 180, 150), np.uint8)
    for x, y, wide, high, colour in things:
        image[y : y + high, x : x + wide] = colour
    return image


class Finder:
    """Finds blue things, ``each`` of them."""

    def __init__(self, each: int = 1, objects: tuple[str, ...] = ("blue",)):
        labels, _ = label_table(objects, {}, each, ColourConfig())
        self.areas = FootageAreas(labels, np.ones(len(objects), bool), each, ColourConfig(), AreaConfig(), RATE)

    def find(self, image: np.ndarray, *faces: tuple[float, float, float, float]):
        found = self.areas.nothing()
        self.areas.show_faces(np.array(faces, float).reshape(-1, 4), False)
        self.areas.find(image, np.zeros(image.shape[:2], np.uint8), found)
        return found


def test_several_of_one_colour_keep_their_places():
    finder = Finder(each=3)
    for step in range(20):
        found = finder.find(table((20 + 4 * step, 100, 12, 12, BLUE), (200 - 4 * step, 160, 16, 16, BLUE)))
    assert found.visible.tolist() == [True, True, False]
    np.testing.assert_allclose(found.px[0], (200 - 76 + 7.5, 167.5))  # the larger one came first, and stays the first
    np.testing.assert_allclose(found.px[1], (20 + 76 + 5.5, 105.5))
    assert candidate_names(("blue", "cup=#00ff00"), 2) == ("blue", "blue_2", "cup", "cup_2")


def test_one_of_several_is_followed_and_not_the_largest():
    finder = Finder()
    finder.find(table((50, 100, 14, 14, BLUE)))
    for _ in range(5):
        found = finder.find(table((52, 100, 14, 14, BLUE), (250, 100, 20, 20, BLUE)))
    assert found.px[0, 0] == pytest.approx(58.5)
    for _ in range(20):
        found = finder.find(table((250, 100, 20, 20, BLUE)))
    assert found.px[0, 0] == pytest.approx(259.5)


def test_a_thing_that_went_on_while_nobody_looked_is_known_at_once():
    """A robot that turns its head takes in no image; meanwhile things are carried farther than they go in one."""
    before, after = table((60, 100, 14, 14, BLUE)), table((110, 60, 14, 14, BLUE))
    for unseen, visible in ((0, False), (12, True)):
        finder = Finder()
        finder.find(before)
        finder.areas.pass_over(unseen)
        assert finder.find(after).visible[0] == visible


@pytest.mark.parametrize("every", [1, 3])
def test_a_lost_thing_is_taken_up_after_half_a_second_at_any_rate(every):
    finder, seen = Finder(), []
    finder.find(table((50, 100, 14, 14, BLUE)))
    for _ in range(every, 31, every):
        finder.areas.pass_over(every - 1)
        seen.append(bool(finder.find(table((250, 100, 20, 20, BLUE))).visible[0]))
    assert seen.index(True) == 15 // every


def test_what_is_large_or_worn_is_no_object():
    face = (150.0, 30.0, 24.0, 32.0)
    assert Finder().find(table((20, 20, 100, 100, BLUE)), face).visible.tolist() == [False]
    shirt = (130, 75, 64, 90, BLUE)
    assert Finder().find(table(shirt), face).visible.tolist() == [False]
    assert Finder().find(table((150, 160, 20, 20, BLUE)), face).visible.tolist() == [True]


@pytest.mark.parametrize("every", [1, 3])
def test_what_goes_with_the_face_is_worn(every):
    """A badge that sways with a person, and a cup that stays where it is, before the chest of the same person."""
    badge, cup = Finder(), Finder()
    for step in range(0, 150, every):
        badge.areas.pass_over(every - 1), cup.areas.pass_over(every - 1)
        sway = round(20 * np.sin(step / 15))
        face = (150.0 + sway, 30.0, 24.0, 32.0)
        worn = badge.find(table((158 + sway, 100, 10, 10, BLUE)), face)
        there = cup.find(table((158, 150, 10, 10, BLUE)), face)
    assert not worn.visible[0]
    assert there.visible[0]


def test_colours_of_a_face_are_no_objects():
    """A hand has them too; a thing of another red is found."""
    skin, face = (205, 90, 60), (150.0, 30.0, 40.0, 50.0)
    image = table((140, 20, 60, 70, skin), (60, 150, 20, 20, skin), (250, 150, 16, 16, (200, 10, 20)))
    found = Finder(each=3, objects=("red",)).find(image, face)
    assert found.visible.sum() == 1 and found.px[0, 0] == pytest.approx(257.5)


class TestPicked:
    def test_a_pale_thing(self):
        """It has no hue to be told by."""
        image = table((100, 100, 30, 30, (120, 122, 125)), (200, 100, 30, 30, (90, 60, 50)))
        image = np.clip(image + np.random.default_rng(0).normal(0, 3, image.shape), 0, 255).astype(np.uint8)
        (sought,) = sought_objects(("cup@0s:115,110",))
        own = colours_at(np.ascontiguousarray(image[..., ::-1]), sought)
        level = image.astype(int) >> 2
        found = own[level[..., 0] << 12 | level[..., 1] << 6 | level[..., 2]]
        assert found[100:130, 100:130].mean() > 0.9
        found[100:130, 100:130] = False
        assert found.mean() < 0.001

    @pytest.mark.parametrize(("item", "words"), [
        ("cup@0s:10,10", "of the image, and is not told"), ("cup@0s:400,10", "the video has 320x240"),
    ])  # fmt: skip
    def test_what_cannot_be_picked(self, item, words):
        with pytest.raises(FootageError, match=words):
            colours_at(table((100, 100, 30, 30, BLUE)), sought_objects((item,))[0])

    def test_two_picks_of_one_thing(self, tmp_path):
        """One thing lies before the other, say: neither may be taken for the other in silence."""
        still = np.repeat(table((100, 100, 30, 30, BLUE), (200, 100, 30, 30, (200, 30, 30)))[None], 3, axis=0)
        video = encode(tmp_path / "a.mkv", still)
        config = PerceiveConfig(video, objects=("cup@0s:110,110", "toy@0s:120,120"), detector=DETECTOR)
        with pytest.raises(FootageError, match="cup and toy have the same colours"):
            next(percepts(config))
        apart = PerceiveConfig(video, objects=("cup@0s:110,110", "toy@0s:210,110"), detector=DETECTOR)
        assert [next(percepts(apart)).objects[name].detected for name in ("cup", "toy")] == [True, True]

    def test_lost_where_hidden(self):
        """It is not found elsewhere meanwhile, and where it comes out again."""
        image = table((100, 100, 24, 24, (120, 122, 125)))
        own = colours_at(np.ascontiguousarray(image[..., ::-1]), sought_objects(("cup@0s:110,110",))[0])
        labels, _ = label_table(("cup@0s:110,110",), {"cup": own}, 1, ColourConfig())
        areas = FootageAreas(labels, np.zeros(1, bool), 1, ColourConfig(), AreaConfig(), RATE)
        said = []
        for step in range(30):
            hidden = [(90, 90, 60, 60, (210, 170, 140))] if 10 <= step < 20 else []
            found = areas.nothing()
            moved = table((100 + step, 100, 24, 24, (120, 122, 125)), *hidden)
            areas.find(moved, np.zeros((240, 320), np.uint8), found)
            said.append(found.px[0, 0])
        assert np.isnan(said[10:20]).all()
        np.testing.assert_allclose(np.delete(said, range(10, 20)), 111.5 + np.delete(np.arange(30), range(10, 20)))

    def test_where_something_else_is_found(self, tmp_path):
        """Something larger has the same colours: that is on the list of what to check, and a good pick is not."""
        image = table((100, 100, 12, 12, (120, 122, 125)), (200, 150, 24, 24, (120, 122, 125)))
        video = encode(tmp_path / "a.mkv", np.repeat(image[None], 9, axis=0))
        for x, y, said in ((104, 104, ["cup not found where it was picked"]), (210, 160, [])):
            viewing = Viewing(PerceiveConfig(video, objects=(f"cup@0.1s:{x},{y}",), detector=DETECTOR))
            viewing.prepare()
            for still in viewing.footage:
                viewing.see(still)
            assert [check.code for check in viewing.checks()] == said
            assert [check.start for check in viewing.checks()] == [3] * len(said)

    def test_later_than_the_video(self, tmp_path):
        video = encode(tmp_path / "a.mp4", counted(10), "-c:v", "libx264")
        with pytest.raises(FootageError, match=r"picked at 5 s.*ends before"):
            next(percepts(PerceiveConfig(video, objects=("cup@5s:3,3",), detector=DETECTOR)))

    @pytest.mark.parametrize("item", ["cup@", "cup@12:3,4", "cup@12s:3", "cup@-1s:3,4", "@1s:3,4", "face@1s:3,4"])
    def test_what_says_no_place(self, item):
        with pytest.raises(ConfigError, match=r"cup@12\.5s:420,310|name of its own"):
            PerceiveConfig(Path("a.mp4"), objects=(item,))

    @needs_gl
    @pytest.mark.integration
    def test_where_it_truly_is(self, tmp_path):
        """Four things on the rendered table, picked in the first second of a compressed video."""
        clip = Clip.rendered("robin", 60, seed=5)
        video = encode(tmp_path / "a.mp4", clip.images, "-vf", "scale=640:480", "-c:v", "libx264", "-crf", "26")
        spots = [f"o{k}@0.5s:{2 * x:.0f},{2 * y:.0f}" for k, (x, y) in enumerate(clip.locations[15, :4])]
        frames = list(percepts(PerceiveConfig(video, objects=tuple(spots), detector=DETECTOR)))
        for k in range(4):
            things = [frame.objects[f"o{k}"] for frame in frames]
            assert np.mean([thing.detected for thing in things]) > 0.95
            off = [np.hypot(thing.x_px - x, thing.y_px - y)
                   for thing, (x, y) in zip(things, clip.locations[:, k], strict=True) if thing.detected]  # fmt: skip
            assert np.median(off) < 3


def test_motion_is_more_than_at_rest():
    rest, rng = Rest(RestConfig(), 2), np.random.default_rng(0)
    said = []
    for step in range(600):
        living = 0.5 + 0.1 * rng.random() + 2.0 * (step % 100 < 20)
        strength = np.array([living, 0.0])
        said.append(rest.moves(strength, strength > 0.08, np.ones(2, bool)))
    said = np.array(said)[100:]
    moving = np.arange(100, 600) % 100 < 20
    np.testing.assert_array_equal(said[:, 0], moving)
    assert not said[:, 1].any()
    assert not rest.moves(np.array([9.0, 9.0]), np.ones(2, bool), np.zeros(2, bool)).any()


@pytest.mark.parametrize("frames", [1, 2, 3])
def test_rest_is_known_after_two_seconds_and_forgotten_after_a_minute_at_any_rate(frames):
    rest, known, forgotten = Rest(RestConfig(), 1), [], []
    for seconds, strength, levels in ((80, 1.0, known), (80, 3.0, forgotten)):
        for _ in range(30 * seconds // frames):
            rest.moves(np.array([strength]), np.ones(1, bool), np.ones(1, bool), frames)
            levels.append(rest.level[0])
    assert np.flatnonzero(np.isfinite(known))[0] * frames == pytest.approx(60, abs=10 * frames)
    assert np.flatnonzero(np.array(forgotten) == 3.0)[0] * frames == pytest.approx(0.6 * 1800, abs=10 * frames)


def test_a_hand_at_the_chin_does_not_move_the_face():
    """Nor does a mouth that speaks; a head that turns does."""
    box = np.array([140.0, 100.0, 24.0, 31.0])
    face = Sighting(1, 1, True, True, np.zeros(15), box, 0.0, 1.0)
    still = cv2.GaussianBlur(np.random.default_rng(0).integers(0, 256, (240, 320), np.uint8), (0, 0), 2.0)
    chin, head = still.copy(), still.copy()
    chin[125:140, 130:180] = still[126:141, 131:181]
    head[90:140, 130:180] = still[90:140, 131:181]
    for moved, moves in ((chin, False), (head, True)):
        followed, detector = FollowedFace(), MotionDetector(FOR_CAMERAS)
        followed.show(face, cv2.cvtColor(still, cv2.COLOR_GRAY2BGR), FrameMap.fitted(320, 240))
        fix = followed.detect(still, None, None)
        seen = [detector.update(image, followed.box(fix, image.shape), Areas.empty(0, 1)) for image in (still, moved)]
        assert seen[-1].face_moves == moves


class TestShots:
    @staticmethod
    def scene(seed: int) -> np.ndarray:
        noise = np.random.default_rng(seed).integers(0, 256, (60, 80, 3), np.uint8)
        return cv2.resize(noise, (960, 720), interpolation=cv2.INTER_CUBIC)

    def test_cuts(self):
        shots, scenes = Shots(ShotConfig()), (self.scene(0), self.scene(1))
        cuts = [shots.see(scenes[step // 20 % 2][:480, :640]) for step in range(60)]
        assert np.flatnonzero(cuts).tolist() == [20, 40]
        assert shots.cuts == 2 and not shots.camera_moves

    def test_a_light_is_switched_on(self):
        shots, image = Shots(ShotConfig()), self.scene(0)[:480, :640] // 2
        assert not any(shots.see(image + np.uint8(60 * (step > 10))) for step in range(20))

    def test_a_camera_that_pans(self):
        shots, image = Shots(ShotConfig()), self.scene(0)
        moves = []
        for step in range(60):
            left = min(max(step - 20, 0), 20) * 3
            assert not shots.see(image[:480, left : left + 640])
            moves.append(shots.camera_moves)
        assert not any(moves[:20]) and all(moves[25:40]) and not any(moves[45:])

    def test_something_large_that_moves_is_no_camera(self):
        shots, image, thing = Shots(ShotConfig()), self.scene(0)[:480, :640], self.scene(1)[:300, :200]
        for step in range(40):
            now = image.copy()
            now[100:400, 50 + 8 * step : 250 + 8 * step] = thing
            shots.see(now)
            assert not shots.cut and not shots.camera_moves


def test_spans(tmp_path):
    spans = Spans(gap=3)
    for frame in (0, 1, 2, 5, 30, 31):
        spans.note("person", "1", frame, 0.9 if frame < 10 else 0.5)
    spans.note("camera", "cut", 30)
    write_spans(tmp_path / "events.csv", spans.all, 2.0)
    assert (tmp_path / "events.csv").read_text().splitlines() == [
        "onset_s,offset_s,tier,code,score",
        "2.000,2.200,person,1,0.900",
        "3.000,3.033,camera,cut,",
        "3.000,3.067,person,1,0.500",
    ]


@pytest.mark.parametrize(("height", "told"), [(0.0, False), (12.0, True), (15.0, False)])
def test_a_face_too_small_to_be_seen_moving_is_told(tmp_path, height, told):
    viewing = Viewing(PerceiveConfig(encode(tmp_path / "a.mkv", counted(3)), detector=DETECTOR))
    for still in viewing.footage:
        viewing.see(still)
    viewing.face_px = height
    assert any("the face is 12 pixels high" in note for note in notes(viewing, False)) == told


@pytest.mark.integration
@pytest.mark.parametrize("name", ["both.mkv", "both.ts"])
def test_times_are_those_of_the_file(tmp_path, name):
    """Sound begins two seconds before the image: players, and so codings, count from there."""
    import subprocess

    import imageio_ffmpeg

    video = encode(tmp_path / "a.mp4", counted(30), "-c:v", "libx264")
    both = tmp_path / name
    sound = ["-f", "lavfi", "-t", "4", "-i", "sine"]
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "error", *sound, "-itsoffset", "2", "-i", str(video)]
    subprocess.run([*command, "-map", "0:a", "-map", "1:v", "-c:v", "copy", str(both)], check=True)
    assert Footage(video).start_s == 0
    assert Footage(both).start_s == pytest.approx(2, abs=0.03)
    viewing = Viewing(PerceiveConfig(both, detector=DETECTOR))
    for still in viewing.footage:
        viewing.see(still)
    assert not any("cut off" in note for note in notes(viewing, False))
    first = next(percepts(PerceiveConfig(both, detector=DETECTOR)))
    assert first.time_s == pytest.approx(2, abs=0.03)
