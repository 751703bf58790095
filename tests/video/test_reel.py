"""A video file that grows: what is in it, and who hears Ctrl-C."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from jointattn_mj.errors import ObservationError, VideoError
from jointattn_mj.video.reel import Reel


def brightness(path: Path) -> list[float]:
    """Of every image that can be decoded."""
    video, found = cv2.VideoCapture(str(path)), []
    while True:
        there, image = video.read()
        if not there:
            return found
        found.append(float(image.mean()))


@pytest.mark.parametrize("quick", [False, True])
def test_images_in_order(tmp_path, quick):
    with Reel(tmp_path / "a.mp4", 48, 64, 10, quick) as reel:
        for level in range(0, 200, 10):
            reel.add(np.full((48, 64, 3), level, np.uint8))
    np.testing.assert_allclose(brightness(tmp_path / "a.mp4"), np.arange(0, 200, 10), atol=4)
    assert cv2.VideoCapture(str(tmp_path / "a.mp4")).get(cv2.CAP_PROP_FPS) == pytest.approx(10)


def test_colours_of_a_quick_film(tmp_path):
    colours = np.array([(200, 30, 30), (30, 200, 30), (30, 30, 200), (200, 200, 30)], np.uint8)
    with Reel(tmp_path / "a.mp4", 64, 64, 10, quick=True) as reel:
        for _ in range(3):
            reel.add(np.repeat(np.repeat(colours.reshape(2, 2, 3), 32, axis=0), 32, axis=1))
    image = cv2.VideoCapture(str(tmp_path / "a.mp4")).read()[1][16::32, 16::32, ::-1]
    np.testing.assert_allclose(image.reshape(4, 3), colours, atol=8)


@pytest.mark.parametrize("size", [(50, 64), (48, 65)])
def test_sizes_that_a_quick_film_cannot_have(tmp_path, size):
    with pytest.raises(VideoError, match=f"multiple of 4.* even; got {size[0]} times {size[1]}"):
        Reel(tmp_path / "a.mp4", *size, 10, quick=True)


@pytest.mark.parametrize(
    "image",
    [*(np.zeros(shape, np.uint8) for shape in ((44, 64, 3), (48, 64), (48, 64, 4))), np.ones((48, 64, 3))],
)
def test_what_is_no_image_of_a_quick_film(tmp_path, image):
    with Reel(tmp_path / "a.mp4", 48, 64, 10, quick=True) as reel:
        with pytest.raises(ObservationError, match=r"image: expected .*\(48, 64, 3\)"):
            reel.add(image)
        reel.add(np.zeros((48, 64, 3), np.uint8))


STOPPED = """
import os, signal, sys
from pathlib import Path
import numpy as np
from jointattn_mj.io.interrupts import deferred
from jointattn_mj.video.reel import Reel
with deferred() as interrupts, Reel(Path(sys.argv[1]), 48, 64, 30) as reel:
    for k in range(200):
        if k == 20:
            os.killpg(0, signal.Signals[sys.argv[2]])
        reel.add(np.full((48, 64, 3), k, np.uint8))
    assert interrupts.requested
"""


@pytest.mark.integration
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_signals_to_all_leave_every_image(tmp_path, name):
    """A terminal sends Ctrl-C to ffmpeg as well, which would finish its file at once."""
    path = tmp_path / "a.mp4"
    done = subprocess.run([sys.executable, "-c", STOPPED, str(path), name], start_new_session=True, capture_output=True)
    assert done.returncode == 0, done.stderr
    assert len(brightness(path)) == 200


def test_signals_are_as_before(tmp_path):
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ())
    with Reel(tmp_path / "a.mp4", 48, 64, 30) as reel:
        assert signal.pthread_sigmask(signal.SIG_BLOCK, ()) == before
        reel.add(np.zeros((48, 64, 3), np.uint8))


def test_no_place_for_it(tmp_path):
    with pytest.raises(VideoError, match="stopped writing"), Reel(tmp_path / "no" / "a.mp4", 48, 64, 30) as reel:
        for _ in range(100):
            reel.add(np.zeros((48, 64, 3), np.uint8))
    assert not os.path.exists(tmp_path / "no")
