"""A video from Python: frame after frame it is the same as from its folder, and the folder is the command's."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from clips import Clip, encode

from jointattn_mj import PerceivedFrame, PerceptionResult, Table, perceive
from jointattn_mj.errors import ConfigError, FootageError, OutputError
from jointattn_mj.footage.config import PerceiveConfig, PerceiveOptions
from jointattn_mj.footage.frames import PerceivedCandidate
from jointattn_mj.footage.run import run_perceive
from jointattn_mj.perception.som import SOMConfig
from jointattn_mj.scene import gl

pytestmark = [
    pytest.mark.integration,
    pytest.mark.skipif(not any(map(gl.available, gl.LIBRARIES)), reason="no OpenGL library to render with"),
]
SOM = SOMConfig(updates=100)
FRAMES = 60


@pytest.fixture(scope="module")
def video(tmp_path_factory) -> Path:
    images = Clip.rendered("amara", FRAMES, seed=3).images
    return encode(tmp_path_factory.mktemp("clip") / "clip.mkv", images)


@pytest.fixture(scope="module")
def frames(video) -> list[PerceivedFrame]:
    return list(perceive(video, som=SOM))


@pytest.fixture(scope="module")
def result(video, tmp_path_factory) -> PerceptionResult:
    return perceive(video, tmp_path_factory.mktemp("perceived") / "out", overlay=False, som=SOM)


def test_frames_are_those_of_the_folder(frames, result):
    assert len(frames) == len(result) == FRAMES
    assert list(result) == frames
    assert frames[0] != frames[1]


def test_a_result_is_what_its_folder_holds(video, result, tmp_path):
    assert PerceptionResult.open(result.folder) == result
    run_perceive(PerceiveConfig(video, som=SOM), PerceiveOptions(tmp_path / "out", overlay=False))
    assert PerceptionResult.open(tmp_path / "out") == result
    assert perceive(video, tmp_path / "out", resume=True, overlay=False, som=SOM) == result
    assert perceive(video, tmp_path / "short", overlay=False, som=SOM, max_minutes=0.01) != result


def test_types_of_attributes(frames, result):
    assert isinstance(result.config, PerceiveConfig) and isinstance(result.summary, dict)
    assert isinstance(result.percepts, Table) and isinstance(result.fixations, Table)
    assert isinstance(result.faces, Table) and result.overlay is None
    for frame in frames:
        assert (type(frame.time_s), type(frame.image), type(frame.fresh)) == (float, int, bool)
        assert frame.fixation in (None, "face", *frame.objects)
        for candidate in (frame.face, *frame.objects.values()):
            fields = dataclasses.fields(PerceivedCandidate)
            kinds = {field.name: type(getattr(candidate, field.name)) for field in fields}
            assert kinds.pop("detected") is kinds.pop("moves") is bool
            assert set(kinds.values()) <= {float, type(None)}
            assert (candidate.x_px is None) == (candidate.y_px is None) == (not candidate.detected)


def test_what_is_perceived(frames):
    """Face and objects are there, frames are a thirtieth of a second apart, and what moves has flow."""
    np.testing.assert_allclose([frame.time_s for frame in frames], np.arange(FRAMES) / 30)
    assert all(frame.face.detected for frame in frames)
    assert list(frames[0].objects) == ["yellow", "blue", "green"]
    moving = [frame for frame in frames if frame.face.moves]
    still = [frame for frame in frames if not frame.face.moves and "face" in frame.flow]
    lengths = [np.mean([np.hypot(*frame.flow["face"]) for frame in some]) for some in (moving, still)]
    assert lengths[0] > 0.045 > lengths[1]


def test_reprs_fit_a_line(frames, result):
    for shown in (frames[20], frames[20].face, frames[20].objects, result):
        assert "\n" not in repr(shown)
    assert len(repr(frames[20])) < 120 and len(repr(frames[20].face)) < 80
    assert repr(result).startswith("PerceptionResult(2.0 s of clip.mkv, face in 100%, ")


def test_only_what_is_asked_for_is_watched(video, frames):
    shown = perceive(video, som=SOM)
    assert next(shown) == frames[0]
    shown.close()
    assert list(perceive(video, som=SOM, max_minutes=0.5 / 60)) == frames[:15]


def test_errors_come_at_once(tmp_path, video):
    with pytest.raises(FootageError):
        perceive(tmp_path / "no.mp4")
    with pytest.raises(ConfigError, match="expected a whole number"):
        perceive(video, seed=-1)
    with pytest.raises(ConfigError, match="resume needs the folder"):
        perceive(video, resume=True)
    with pytest.raises(OutputError, match="missing or damaged"):
        (tmp_path / "config.yaml").write_text("config: {video: a.mp4}")
        PerceptionResult.open(tmp_path)
