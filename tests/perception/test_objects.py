"""Colour areas: where they are, that shading, stray pixels and occlusion do little, that wrong colours are refused."""

import pickle

import cv2
import numpy as np
import pytest
from stage import Stage

from jointattn_mj.errors import ConfigError
from jointattn_mj.perception.objects import ColourAreas
from jointattn_mj.scene.model import SceneConfig
from jointattn_mj.scene.objects import OBJECTS

RGB = np.array([o.rgb for o in OBJECTS[:4]])
WOOD = (150, 130, 110)


def painted(boxes, background=WOOD):
    """An image with a filled box (x0, y0, x1, y1, rgb 0..1) for each entry."""
    image = np.full((240, 320, 3), background, np.uint8)
    for x0, y0, x1, y1, rgb in boxes:
        image[y0:y1, x0:x1] = np.round(np.asarray(rgb) * 255)
    return image


def test_area_centre_and_box_are_exact():
    areas = ColourAreas(RGB).segment(painted([(50, 60, 67, 76, RGB[0]), (201, 33, 214, 45, RGB[2])]))[1]
    assert areas.visible.tolist() == [True, False, True, False]
    assert areas.area.tolist() == [17 * 16, 0, 13 * 12, 0]
    assert areas.px[0] == pytest.approx([58.0, 67.5]) and areas.px[2] == pytest.approx([207.0, 38.5])
    assert np.isnan(areas.px[[1, 3]]).all()
    assert areas.box[0].tolist() == [50, 60, 67, 76]
    x, y = areas.corner[2]
    assert areas.mask[2].sum() == 13 * 12 and areas.mask[2][33 - y : 45 - y, 201 - x : 214 - x].all()


@pytest.mark.parametrize("shade", [1.15, 0.7, 0.45, 0.3])
def test_shading_keeps_the_colour(shade):
    shaded = np.clip(RGB * shade, 0, 1)
    image = painted([(20 + 60 * k, 100, 36 + 60 * k, 116, rgb) for k, rgb in enumerate(shaded)])
    areas = ColourAreas(RGB).segment(image)[1]
    assert areas.area.tolist() == [256] * 4


def test_stray_pixels_elsewhere_do_not_bend_the_centre():
    image = painted([(50, 60, 66, 76, RGB[0])])
    rng = np.random.default_rng(0)
    image[rng.integers(100, 240, 60), rng.integers(100, 320, 60)] = np.round(RGB[0] * 255)
    areas = ColourAreas(RGB).segment(image)[1]
    assert areas.px[0] == pytest.approx([57.5, 67.5]) and areas.area[0] == 256


@pytest.mark.parametrize(("dx", "dy"), [(0, 0), (5, 3), (8, 11), (15, 15)])
def test_an_object_across_cells_stays_whole(dx, dy):
    areas = ColourAreas(RGB).segment(painted([(96 + dx, 96 + dy, 120 + dx, 120 + dy, RGB[1])]))[1]
    assert areas.area[1] == 24 * 24
    assert areas.px[1] == pytest.approx([107.5 + dx, 107.5 + dy])


def test_a_sliver_is_seen_and_a_speck_is_not():
    areas = ColourAreas(RGB).segment(painted([(50, 60, 53, 76, RGB[0]), (200, 60, 202, 62, RGB[1])]))[1]
    assert areas.visible.tolist() == [True, False, False, False]


def test_gray_is_opencvs_and_survives_pickling():
    rng = np.random.default_rng(1)
    image = rng.integers(0, 256, (240, 320, 3), dtype=np.uint8)
    finder = pickle.loads(pickle.dumps(ColourAreas(RGB)))
    gray, areas = finder.segment(image)
    assert (gray == cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)).all()
    assert areas.visible.any() and not finder.segment(np.zeros_like(image))[1].visible.any()


@pytest.mark.parametrize(
    "rgb",
    [
        [(0.5, 0.5, 0.5)],  # grey has no hue
        [(0.1, 0.0, 0.0)],  # too dark
        [(0.9, 0.1, 0.1), (0.8, 0.1, 0.1)],  # the same hue twice
        [(200, 10, 10)],  # bytes for fractions
        np.zeros((0, 3)),
    ],
)
def test_colours_that_cannot_be_told_apart_are_refused(rgb):
    with pytest.raises(ConfigError, match="expected"):
        ColourAreas(rgb)


def test_rendered_objects_are_where_they_are():
    stage = Stage()
    finder = ColourAreas(RGB)
    for pan, tilt in [(0, 3), (15, -14), (-18, -16)]:
        stage.look_from(pan, tilt)
        areas = finder.segment(stage.image())[1]
        for k, thing in enumerate(OBJECTS[:4]):
            true = stage.pixel(stage.location_of(thing.name))
            if 12 < true[0] < 308 and 12 < true[1] < 228:
                assert areas.visible[k] and np.hypot(*(areas.px[k] - true)) < 2, (thing.name, areas.px[k], true)
    for thing in OBJECTS[:4]:
        stage.put(thing.name, (0, 0, -5))
    assert not finder.segment(stage.image())[1].visible.any(), "skin, hair, clothes, wood or wall pass for an object"
    stage.close()


def test_ten_colours_are_told_apart():
    stage = Stage(SceneConfig(objects=OBJECTS))
    finder = ColourAreas([o.rgb for o in OBJECTS])
    stage.look_from(0, -12)
    areas = finder.segment(stage.image())[1]
    for k, thing in enumerate(OBJECTS):
        true = stage.pixel(stage.location_of(thing.name))
        assert areas.visible[k] and np.hypot(*(areas.px[k] - true)) < 3, thing.name
    for thing in OBJECTS[:5]:
        stage.put(thing.name, (0, 0, -5))
    assert finder.segment(stage.image())[1].visible.tolist() == [False] * 5 + [True] * 5
    stage.close()
