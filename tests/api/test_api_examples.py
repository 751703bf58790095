"""The examples in the docstrings of public names do what they say."""

import doctest
from pathlib import Path

import pytest
from clips import Clip, encode

import jointattn_mj
from jointattn_mj.footage.frames import PerceivedFrame
from jointattn_mj.gaze_following.result import FinishedSession
from jointattn_mj.gaze_following.summary import SessionSummary
from jointattn_mj.io.summaries import Summary
from jointattn_mj.recordings import Coding, Events, ReadOptions, Recordings
from jointattn_mj.scene import gl

pytestmark = pytest.mark.integration

STATE = [
    "Session", "SessionResult", "Development", "DevelopmentResult", "Table", "load", "read_recordings", "run_claim",
    "ClaimResult",
]  # fmt: skip
IMAGES = ["perceive", "PerceptionResult"]
needs_gl = pytest.mark.skipif(not any(map(gl.available, gl.LIBRARIES)), reason="no OpenGL library to render with")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch) -> Path:
    (tmp_path / "out").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def check(public: str | type) -> None:
    """Run the examples of a public name, or of a class, and of its methods."""
    tried, name = 0, public if isinstance(public, str) else public.__name__
    documented = getattr(jointattn_mj, public) if isinstance(public, str) else public
    for test in doctest.DocTestFinder().find(documented, name, globs={}):
        told: list[str] = []
        result = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(test, out=told.append)
        assert not result.failed, "".join(told)
        tried += result.attempted
    assert tried, f"{name} has no example"


@pytest.mark.parametrize("name", STATE)
def test_an_example(name):
    check(name)


@pytest.mark.parametrize(
    "kind",
    [Recordings, PerceivedFrame, SessionSummary, Summary, FinishedSession, Events, Coding, ReadOptions],
    ids=lambda kind: kind.__name__,
)
def test_an_example_of_what_is_returned(kind):
    """Classes that nobody makes, but everybody gets."""
    check(kind)


@needs_gl
@pytest.mark.parametrize("name", IMAGES)
def test_an_example_with_a_video(name, folder):
    encode(folder / "out" / "clip.mp4", Clip.rendered("amara", 60, seed=3).images, "-c:v", "libx264")
    check(name)
