"""From a video's images to the robot's: what is where, and back."""

import numpy as np
import pytest

from jointattn_mj.errors import FootageError
from jointattn_mj.footage.frame_map import IMAGE_HEIGHT, IMAGE_WIDTH, FrameMap

MAPS = {
    "the same": FrameMap.fitted(320, 240),
    "twice": FrameMap.fitted(640, 480),
    "wide": FrameMap.fitted(1280, 720),
    "upright": FrameMap.fitted(720, 1280),
    "odd": FrameMap.fitted(333, 251),
    "filled": FrameMap.fitted(1280, 720, fit="fill"),
    "long pixels": FrameMap.fitted(720, 576, 16 / 11),
    "small": FrameMap.fitted(40, 30),
    "scaled": FrameMap.scaled(640, 480, 1.0, 0.2),
    "too large": FrameMap.scaled(640, 480, 1.0, 1.3),
}


@pytest.mark.parametrize("name", MAPS)
@pytest.mark.parametrize("times", [1, 2])
def test_a_spot_is_where_the_map_says(name, times):
    mapped = MAPS[name]
    video = np.zeros((mapped.height, mapped.width, 3), np.uint8)
    side = max(4, round(24 / mapped.scale_x))
    x, y = mapped.width // 2 + side // 3, mapped.height // 2 - side // 4
    video[y : y + side, x : x + side] = (0, 0, 255)  # BGR
    image = mapped.image(video, times)
    assert image.shape == (IMAGE_HEIGHT * times, IMAGE_WIDTH * times, 3)
    assert image[..., 0].max() > 200 and not image[..., 1:].any()  # red in RGB
    weight = image[..., 0].astype(float)
    rows, columns = np.mgrid[: weight.shape[0], : weight.shape[1]]
    visible = np.array([(weight * columns).sum(), (weight * rows).sum()]) / weight.sum()
    centre = np.array([x, y]) + (side - 1) / 2
    expected = (mapped.to_image(centre) + 0.5) * times - 0.5
    np.testing.assert_allclose(visible, expected, atol=0.6)
    np.testing.assert_allclose(mapped.to_video(mapped.to_image(centre)), centre, atol=1e-9)


def test_whole_images_fit_and_keep_their_shape():
    for name in ("twice", "wide", "upright", "odd", "small"):
        mapped = MAPS[name]
        assert mapped.left >= 0 and mapped.top >= 0
        assert min(mapped.left, mapped.top) == 0
        assert mapped.scale_x == pytest.approx(mapped.scale_y, rel=0.01)
    wide = MAPS["wide"].image(np.full((720, 1280, 3), 200, np.uint8))
    assert (wide[30:210] == 200).all() and not wide[:30].any() and not wide[210:].any()
    assert (MAPS["filled"].image(np.full((720, 1280, 3), 200, np.uint8)) == 200).all()
    assert MAPS["long pixels"].scale_x == pytest.approx(16 / 11 * MAPS["long pixels"].scale_y, rel=0.01)


def test_an_equal_image_is_not_touched():
    video = np.random.default_rng(0).integers(0, 255, (240, 320, 3), np.uint8)
    np.testing.assert_array_equal(MAPS["the same"].image(video), video[..., ::-1])


def test_what_is_not_seen_is_nowhere():
    assert np.isnan(MAPS["wide"].to_video(np.array([[np.nan, np.nan]]))).all()


@pytest.mark.parametrize(("width", "height"), [(1, 1), (1, 900), (900, 1), (7680, 4320)])
def test_extreme_sizes(width, height):
    image = FrameMap.fitted(width, height).image(np.full((height, width, 3), 90, np.uint8))
    assert image.max() == 90


def test_a_video_is_not_made_larger_than_memory_is():
    assert FrameMap.scaled(640, 480, 1.0, 10.0).scale_x == 10
    with pytest.raises(FootageError, match=r"3840x2160 .* 38400x21600.*`scale`"):
        FrameMap.scaled(3840, 2160, 1.0, 10.0)
