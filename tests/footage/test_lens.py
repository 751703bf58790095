"""Digital pan and tilt: the geometry agrees with that of the robot's eye, and the head stays inside the wide image."""

import numpy as np
import pytest

from jointattn_mj.errors import FootageError
from jointattn_mj.footage.sessions.head import DigitalHead
from jointattn_mj.footage.sessions.lens import HeadConfig, Lens
from jointattn_mj.scene.camera import pixel_of
from jointattn_mj.scene.world import World, WorldConfig

WIDE = HeadConfig(fov_deg=117.6, mount_deg=-6.5)
HEADS = ((0.0, 0.0), (12.0, -15.0), (-20.0, 5.0), (0.0, -6.5))


@pytest.mark.parametrize("head", HEADS)
@pytest.mark.parametrize("config", (WIDE, HeadConfig(border="black"), HeadConfig(view_share=0.4, mount_deg=20)))
def test_a_pixel_of_the_wide_image_is_where_its_direction_is(config, head):
    lens, head = Lens(880, 640, config), np.array(head)
    pixels = np.random.default_rng(0).uniform((300, 200), (580, 440), (50, 2))
    expected = np.array([pixel_of(lens.direction(pixel), head) for pixel in pixels])
    np.testing.assert_allclose(lens.to_image(pixels, head), expected, atol=1e-6)


def test_a_crop_shows_what_the_map_says():
    lens, wide_image = Lens(880, 640, WIDE), np.zeros((640, 880, 3), np.uint8)
    wide_image[298:303, 498:503] = (0, 0, 255)  # BGR
    head = np.array([-5.0, -3.0])
    image = lens.crop(wide_image, head)
    y, x = (values.mean() for values in np.nonzero(image[..., 0] > 60))
    np.testing.assert_allclose((x, y), lens.to_image(np.array([[500.0, 300.0]]), head)[0], atol=0.2)
    assert image[..., 2].max() == 0  # the image is RGB


def test_a_fine_image_is_averaged_before_it_is_sampled():
    lens = Lens(3520, 2560, WIDE)
    wide_image = np.indices((2560, 3520)).sum(axis=0) % 2 * 255  # a chequered board, a pixel a field
    image = lens.crop(np.repeat(wide_image[..., None], 3, axis=2).astype(np.uint8), np.array([3.0, -9.0]))
    assert np.abs(image[10:-10, 10:-10].astype(int) - 127).max() < 30


@pytest.mark.parametrize("wanted", [(pan, tilt) for pan in (-80, -20, 0, 30) for tilt in (-70, -20, 0, 60)])
def test_the_head_stays_inside_the_wide_image(wanted):
    lens = Lens(880, 640, WIDE)
    pan, tilt = lens.limited(np.array(wanted, float))
    assert lens.fits(pan, tilt)
    assert (pan, tilt) == wanted or not lens.fits(*wanted)
    assert pan * wanted[0] >= 0
    free = Lens(880, 640, HeadConfig(fov_deg=117.6, border="black"))
    np.testing.assert_array_equal(free.limited(np.array(wanted, float)), np.clip(wanted, (-90, -60), (90, 60)))


def test_a_narrow_field_of_view_is_refused_in_words():
    for config in (HeadConfig(fov_deg=70), HeadConfig(view_share=1.0), HeadConfig(fov_deg=30)):
        with pytest.raises(FootageError, match=r"could turn by \d+ degrees aside.*border='black'"):
            Lens(1280, 720, config)
        Lens(1280, 720, HeadConfig(fov_deg=config.fov_deg, view_share=config.view_share, border="black"))
    assert min(Lens(1280, 720, HeadConfig()).reach()) > 5


def test_the_digital_head_moves_as_the_rendered_one():
    world, head = World.build(WorldConfig(), np.random.SeedSequence(0)), DigitalHead()
    rng, command = np.random.default_rng(1), np.zeros(2)
    for frame in range(60):
        command = rng.uniform(-0.4, 0.4, 2) if frame % 20 == 0 else command
        world.step(command)
        head.step(command)
        np.testing.assert_allclose(head.angles, world.head_angles(), atol=1e-9)
        assert head.moves == world.head_moves()
    other = DigitalHead.__new__(DigitalHead)
    other.__setstate__(head.__getstate__())
    other.step(command), head.step(command)
    np.testing.assert_array_equal(other.angles, head.angles)
    world.close()
