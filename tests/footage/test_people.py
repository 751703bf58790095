"""Real people: who is found where, who is whom, and what is said of it. Clips are beside the project, or not there."""

import os
from pathlib import Path

import cv2
import numpy as np
import pyarrow.parquet as pq
import pytest
from clips import DETECTOR, counted, encode
from shell import refused

from jointattn_mj.errors import ConfigError, ExtraError
from jointattn_mj.footage import people, yunet
from jointattn_mj.footage.blurring import blurred
from jointattn_mj.footage.config import PerceiveConfig, PerceiveOptions
from jointattn_mj.footage.head import MOST_DEG, NOSE, yaw_of
from jointattn_mj.footage.interest import FaceOfInterest, FaceRule
from jointattn_mj.footage.people import People, PeopleConfig, Sighting
from jointattn_mj.footage.run import run_perceive
from jointattn_mj.footage.yunet import square

CLIPS = Path(os.environ.get("JOINTATTN_CLIPS", Path(__file__).parents[3] / "shared" / "clips"))
needs_network = pytest.mark.skipif(DETECTOR != "yunet", reason="the extra footage is not installed")
needs_clips = pytest.mark.skipif(not CLIPS.is_dir(), reason="the clips of real people are not beside the project")


def images(name: str) -> list[np.ndarray]:
    capture, read = cv2.VideoCapture(str(CLIPS / name)), []
    while (image := capture.read()[1]) is not None:
        read.append(image)
    return read


def watched(name: str, out: Path, **options) -> tuple[dict, list[dict]]:
    """The summary, and the rows of all faces."""
    summary = run_perceive(PerceiveConfig(CLIPS / name, **options), PerceiveOptions(out, overlay=False))
    return summary, pq.read_table(out / "people.parquet").to_pylist()


class TestWithoutTheExtra:
    def test_it_is_named(self, jointattn, monkeypatch, tmp_path):
        monkeypatch.setattr(yunet, "find_spec", lambda name: None)
        with pytest.raises(ExtraError, match=r"pip install 'jointattn-mj\[footage\]'.*detector=.templates"):
            PerceiveConfig(tmp_path / "a.mp4") and yunet.model_file()

    @pytest.mark.skipif(DETECTOR == "yunet", reason="the extra footage is installed")
    def test_nothing_is_watched(self, jointattn, tmp_path):
        video = encode(tmp_path / "a.mp4", counted(5), "-c:v", "libx264")
        refused(jointattn("perceive", video, "--out", tmp_path / "out"), 2, "jointattn-mj[footage]")
        assert not (tmp_path / "out").exists()

    def test_another_network_is_refused(self, monkeypatch, tmp_path):
        (tmp_path / "another.onnx").write_bytes(b"another")
        monkeypatch.setattr(yunet, "model_file", lambda: tmp_path / "another.onnx")
        with pytest.raises(ExtraError, match=r"not the network that was tested"):
            yunet._model.__wrapped__()


class TestYaw:
    @staticmethod
    def landmarks(yaw_deg: float, roll_deg: float = 0) -> np.ndarray:
        """A face whose nose stands out by as much as is assumed, from a distance."""
        yaw, roll = np.radians([yaw_deg, roll_deg])
        across = np.array([-20.0, 20, 0, -16, 16]) * np.cos(yaw)
        across[2] += 40 / NOSE * np.sin(yaw)
        down = np.array([0.0, 0, 20, 40, 40])
        turn = np.array([[np.cos(roll), np.sin(roll)], [-np.sin(roll), np.cos(roll)]])
        return np.column_stack([across, down]) @ turn + 100

    @pytest.mark.parametrize("yaw", [-50, -20, 0, 10, 45])
    @pytest.mark.parametrize("roll", [0, 30])
    def test_as_the_nose_stands_out(self, yaw, roll):
        said, error = yaw_of(self.landmarks(yaw, roll), 60)
        assert said == pytest.approx(yaw, abs=0.5)
        assert 3 < error < 20

    def test_where_it_cannot_be_measured(self):
        assert np.isnan(yaw_of(self.landmarks(MOST_DEG + 10), 60)).all()
        assert np.isnan(yaw_of(self.landmarks(0), 10)).all()
        assert np.isnan(yaw_of(np.zeros((5, 2)), 60)).all()

    def test_smaller_faces_and_larger_yaws_are_less_exact(self):
        errors = [yaw_of(self.landmarks(yaw), high)[1] for yaw, high in ((0, 90), (0, 25), (45, 25))]
        assert errors == sorted(errors) and errors[0] < 0.7 * errors[1]


class TestFaceOfInterest:
    @staticmethod
    def face(track: int, x: float, high: float, person: int = 0) -> Sighting:
        box = np.array([x, 50, high, high])
        return Sighting(track, person or track, True, True, np.concatenate([box, np.zeros(10), [0.9]]), box, 0.0, 3.0)

    def test_the_largest_stays_for_a_while(self):
        interest = FaceOfInterest(FaceRule.parsed("largest"))
        small, large = self.face(1, 0, 40), self.face(2, 100, 80)
        assert interest.choose([small], 0, False) is small
        chosen = [interest.choose([large, small], frame, False).track for frame in range(1, 61)]
        assert chosen[:30] == [1] * 30 and chosen[-1] == 2

    def test_a_while_is_a_second_at_any_rate(self):
        small, large = self.face(1, 0, 40), self.face(2, 100, 80)
        for every in (1, 2, 3, 6):
            there, gone = (FaceOfInterest(FaceRule.parsed("largest")) for _ in range(2))
            there.choose([small], 0, False), gone.choose([small], 0, False)
            frames = range(every, 61, every)
            chosen = [there.choose([large, small], frame, False).track for frame in frames]
            assert chosen == [1 if frame <= 30 else 2 for frame in frames]
            chosen = [gone.choose([large], frame, False) for frame in frames]
            assert chosen == [None if frame <= 30 else large for frame in frames]

    def test_nobody_takes_its_place_for_a_moment(self):
        interest = FaceOfInterest(FaceRule.parsed("largest"))
        first, second = self.face(1, 0, 80), self.face(2, 100, 40)
        interest.choose([first, second], 0, False)
        assert interest.choose([second], 1, False) is None
        assert interest.choose([first, second], 2, False) is first
        assert interest.choose([second], 3, True) is second  # after a cut it may be anybody

    def test_a_person_and_a_region(self):
        first, second = self.face(1, 0, 80), self.face(2, 100, 40)
        assert FaceOfInterest(FaceRule.parsed("2")).choose([first, second], 0, False) is second
        assert FaceOfInterest(FaceRule.parsed("90,0,200,200")).choose([first, second], 0, False) is second
        assert FaceOfInterest(FaceRule.parsed("3")).choose([first, second], 0, False) is None

    @pytest.mark.parametrize("words", ["", "smallest", "0", "1,2,3", "10,10,5,20", "-1", "1e3"])
    def test_what_is_none(self, words):
        with pytest.raises(ConfigError, match="largest, the number of a person, or a region"):
            PerceiveConfig(Path("a.mp4"), face=words)

    def test_templates_tell_nobody_apart(self, tmp_path):
        """So they cannot blur everybody, either."""
        with pytest.raises(ConfigError, match="blur_faces: only the detector yunet"):
            run_perceive(
                PerceiveConfig(Path("a.mp4"), detector="templates"), PerceiveOptions(tmp_path, blur_faces=True)
            )
        with pytest.raises(ConfigError, match="only the detector yunet"):
            PerceiveConfig(Path("a.mp4"), face="2", detector="templates")


def test_a_window_beyond_the_border_is_black():
    image = np.full((40, 50, 3), 7, np.uint8)
    part = square(image, -10, 30, 20)
    assert part[:10, 10:].min() == 7 and part[:, :10].max() == 0 and part[10:].max() == 0
    assert not square(image, 100, 100, 20).any()


def test_a_blurred_face_is_unrecognisable():
    """Next to nothing is left of its fine structure, the rest stays, and the image itself is not touched."""
    image = np.random.default_rng(0).integers(0, 256, (200, 200, 3), np.uint8)
    kept = image.copy()
    hidden = blurred(image, np.array([[80.0, 80, 40, 50], [190, -20, 40, 50]]))
    np.testing.assert_array_equal(image, kept)
    assert hidden[80:130, 80:120].std() < 0.25 * image.std()
    np.testing.assert_array_equal(hidden[:, :60], image[:, :60])


def test_where_a_face_was_lost_stays_blurred(monkeypatch):
    """The network misses a face at the border that anybody recognises; after ten seconds, or a cut, it is gone."""
    image = np.random.default_rng(0).integers(0, 256, (120, 160, 3), np.uint8)
    face = np.array([[40, 30, 30, 40, 48, 45, 62, 45, 55, 52, 49, 62, 61, 62, 0.9]], np.float32)
    monkeypatch.setattr(people, "faces_in", lambda *_: face)
    monkeypatch.setattr(people, "faces_near", lambda image, boxes, *_: np.full((len(boxes), 15), np.nan, np.float32))
    for cut in (False, True):
        known, hidden = People(PeopleConfig(), 10, 0.4), []
        known.see(image, 0, True)
        monkeypatch.setattr(people, "faces_in", lambda *_: face[:0])
        for frame in range(1, 115):
            known.see(image, frame, cut and frame == 50)
            hidden.append(len(known.to_blur()))
        assert hidden == ([1] * 49 + [0] * 65 if cut else [1] * 100 + [0] * 14)
        monkeypatch.setattr(people, "faces_in", lambda *_: face)


@needs_network
@needs_clips
@pytest.mark.integration
class TestClips:
    @pytest.mark.parametrize(
        ("name", "faces", "left", "right", "low", "high"),
        [
            ("asl_brother.mkv", 1, 200, 400, 60, 170),  # a skull of face size is on the shirt, from y 190 on
            ("asl_sister.mkv", 1, 250, 400, 40, 200),
            ("asl_yes.mkv", 1, 220, 400, 20, 170),
            ("head-pose-face-detection-female.gif", 1, 150, 330, 20, 160),  # begins in profile
            ("face-demographics-walking.gif", 2, 170, 345, 95, 145),
        ],
    )
    def test_on_the_face(self, tmp_path, name, faces, left, right, low, high):
        summary, rows = watched(name, tmp_path / "out")
        shown = summary["video"]["images_read"]
        assert len(rows) == faces * shown
        assert sum(row["of_interest"] for row in rows) == shown
        centres = np.array([(row["x_px"] + row["width_px"] / 2, row["y_px"] + row["height_px"] / 2) for row in rows])
        assert (centres > (left, low)).all() and (centres < (right, high)).all()
        assert [person["images_unsure"] for person in summary["people"]] == [0] * faces

    def test_cuts(self, tmp_path):
        """Four people; a face in all images but some at the cuts, and the four are never said to be three for sure."""
        summary, rows = watched("syn_cuts.mp4", tmp_path / "out")
        assert summary["video"]["cuts"] == 3
        assert [moment["what"] for moment in summary["check"]].count("cut") == 3
        assert len({row["image"] for row in rows}) >= 0.98 * 300
        parts = [{row["person"] for row in rows if row["sure"] and low < row["image"] < high}
                 for low, high in ((0, 75), (90, 135), (150, 215), (235, 300))]  # fmt: skip
        known = [person for part in parts for person in part]
        assert len(known) == len(set(known)) >= 3
        for person in summary["people"]:  # from the first image on, and not from when it was known who it is
            own = [row for row in rows if row["person"] == person["person"]]
            assert person["images"] == len(own)
            assert person["images_unsure"] == sum(not row["sure"] for row in own)
            times = [round(row["frame"] / 30, 3) for row in own]
            assert (person["from_s"], person["to_s"]) == (min(times), max(times))

    def test_lost_is_lost(self, tmp_path):
        """A face that leaves by the border is not there, is on the list, and is the same afterwards."""
        summary, rows = watched("syn_border.mp4", tmp_path / "out")
        missing = sorted(set(range(240)) - {row["image"] for row in rows})
        assert 30 <= len(missing) <= 60 and missing[-1] - missing[0] < 70
        assert min(row["x_px"] + row["width_px"] / 2 for row in rows) >= 0  # what lies beyond is guessed
        lost = next(moment for moment in summary["check"] if moment["what"] == "face lost")
        assert lost["from_s"] == pytest.approx(missing[0] / 30, abs=0.1)
        assert [person["person"] for person in summary["people"]] == [1]
        assert any("camera moves" in note for note in summary["notes"])

    def test_a_person_who_is_not_there(self, tmp_path):
        """Faces were found, but none of person 9: the note says who there is, not how large a face must be."""
        summary, rows = watched("asl_yes.mkv", tmp_path / "out", face="9")
        assert rows and not any(row["of_interest"] for row in rows)
        assert "no face was the face of interest, 9; the people in the video are 1" in summary["notes"]
        assert not any("no face was found" in note for note in summary["notes"])

    def test_people_who_come_back(self):
        """Over cuts, from other recordings of the same people."""
        order = ("asl_brother.mkv", "asl_walk.mkv", "asl_yes.mkv", "asl_sister.mkv", "asl_walk.mkv")
        people, found, frame = People(PeopleConfig(), 30, 0.4), [], 0
        for name in order:
            for k, image in enumerate(images(name)[:40]):
                seen = people.see(image, frame, k == 0 and frame > 0)
                frame += 1
            found.append((seen[0].person, seen[0].sure))
        assert [person for person, _ in found] == [1, 2, 1, 3, 2]  # the first and the third clip show one man
        assert [sure for _, sure in found][:3] == [True] * 3

    def test_clothes_and_skin_are_no_objects(self, tmp_path):
        """A woman in an orange jumper, which is yellow in part; skin is red, and hers and his are learned."""
        for objects in (("yellow", "blue", "green"), ("red", "orange")):
            found = watched("asl_walk.mkv", tmp_path / objects[0], objects=objects)[0]["detected"]
            assert max(found[name] for name in objects) < 0.05

    def test_blurred_overlay(self, jointattn, tmp_path):
        """Nobody is found in it any more."""
        out = tmp_path / "out"
        outcome = jointattn("perceive", CLIPS / "asl_yes.mkv", "--out", out, "--blur-faces", "--som.updates", 10)
        assert (outcome.code, outcome.err) == (0, "")
        assert not (out / "som.png").exists()
        capture = cv2.VideoCapture(str(out / "overlay.mp4"))
        shown = [capture.read()[1][44:524, 16:656] for _ in range(65)]
        assert sum(len(yunet.faces_in(np.ascontiguousarray(image), 0.75)) for image in shown) == 0
