"""Images as pieces of H.264: all of them, in their order, and one can begin at a key image."""

import cv2
import imageio_ffmpeg
import numpy as np
import pytest

from jointattn_mj.errors import VideoError
from jointattn_mj.video import stream
from jointattn_mj.video.stream import VideoEncoder, can_encode

SHAPE = (48, 64, 3)
needs_encoder = pytest.mark.skipif(not can_encode(), reason="no ffmpeg with H.264")


def images(count: int) -> list[np.ndarray]:
    """Grey images, each brighter than the one before."""
    return [np.full(SHAPE, 20 + 3 * number, np.uint8) for number in range(count)]


def brightness(samples: list[bytes], path) -> np.ndarray:
    """Mean of every image that a decoder makes of samples."""
    path.write_bytes(b"".join(samples))
    video, means = cv2.VideoCapture(str(path)), []
    while True:
        there, image = video.read()
        if not there:
            return np.array(means)
        means.append(image.mean())


@pytest.fixture
def nowhere(monkeypatch):
    def absent() -> str:
        raise RuntimeError("No ffmpeg exe could be found.")

    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_exe", absent)


@needs_encoder
def test_every_image_becomes_a_unit(tmp_path):
    encoder = VideoEncoder(SHAPE[0], SHAPE[1], 10)
    units = []
    for image in images(64):
        encoder.add(image)
        units += encoder.take()
    units += encoder.finish()
    assert [number for number, unit in enumerate(units) if unit.key] == list(range(0, 64, 10))
    expected = np.array([image.mean() for image in images(64)])
    np.testing.assert_allclose(brightness([unit.sample for unit in units], tmp_path / "all.h264"), expected, atol=2.5)
    late = [unit.sample for unit in units[40:]]
    np.testing.assert_allclose(brightness(late, tmp_path / "late.h264"), expected[40:], atol=2.5)


@needs_encoder
def test_units_come_while_it_goes_on():
    """No more than a few images are held back."""
    encoder, given, taken = VideoEncoder(SHAPE[0], SHAPE[1], 10), 0, 0
    while taken <= 64 and given < 2000:
        encoder.add(images(64)[given % 64])
        given += 1
        taken += len(encoder.take())
    assert taken > 64
    assert len(encoder.finish()) == given - taken


@needs_encoder
def test_nothing_to_encode():
    assert VideoEncoder(SHAPE[0], SHAPE[1], 10).finish() == []


@needs_encoder
@pytest.mark.parametrize("image", [np.zeros((48, 62, 3), np.uint8), np.zeros(SHAPE)], ids=["size", "type"])
def test_other_images(image):
    encoder = VideoEncoder(SHAPE[0], SHAPE[1], 10)
    with pytest.raises(VideoError, match="expected uint8"):
        encoder.add(image)
    encoder.finish()


@needs_encoder
def test_ffmpeg_gives_up():
    encoder = VideoEncoder(SHAPE[0], SHAPE[1], 10)
    encoder._program.kill()
    with pytest.raises(VideoError, match="ffmpeg"):
        for image in images(64) * 20:
            encoder.add(image)
    with pytest.raises(VideoError, match="ffmpeg"):
        encoder.finish()


def test_no_ffmpeg(nowhere):
    assert not stream.can_encode()
    with pytest.raises(VideoError, match="apt-get install ffmpeg"):
        VideoEncoder(SHAPE[0], SHAPE[1], 10)
