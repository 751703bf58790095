"""Areas of colours in batches: those of each image alone, to the bit."""

import numpy as np
import pytest

from jointattn_mj.errors import ObservationError
from jointattn_mj.perception.batched_areas import BatchedColourAreas, batched_gray
from jointattn_mj.perception.objects import ColourAreas
from jointattn_mj.scene.objects import OBJECTS

RGB = np.array([thing.rgb for thing in OBJECTS[:6]])


@pytest.fixture(scope="module")
def torch():
    """Imported when it is needed: it takes a second."""
    return pytest.importorskip("torch")


def images(height, width, seed):
    """Noise without colour; on it discs of the objects' colours, of any size, some cut by the border or in two parts;
    and one image of nothing but coloured noise."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:height, :width]
    made = np.repeat(rng.integers(60, 200, (6, height, width, 1), np.uint8), 3, axis=3)
    for image in made:
        for rgb in RGB[rng.random(len(RGB)) < 0.8]:
            for _ in range(rng.integers(1, 3)):
                away = np.hypot(x - rng.uniform(-4, width + 4), y - rng.uniform(-4, height + 4))
                image[away < rng.uniform(0.5, 14)] = rgb * rng.uniform(160, 255)
    made[0] = rng.integers(0, 256, made[0].shape)
    return made


@pytest.mark.parametrize(("height", "width"), [(240, 320), (64, 64), (56, 88)])
def test_same_as_one_by_one(torch, height, width):
    made, alone = images(height, width, seed=height), ColourAreas(RGB)
    tensor = torch.as_tensor(made)
    found, gray, visible = BatchedColourAreas(RGB).find(tensor), batched_gray(tensor).numpy(), []
    for number, image in enumerate(made):
        own, (its_gray, labels) = found.of(number), alone.segment(image)
        assert np.array_equal(gray[number], its_gray)
        for name in ("visible", "area", "px", "box"):
            assert np.array_equal(getattr(own, name), getattr(labels, name), equal_nan=name == "px"), (number, name)
            assert getattr(own, name).dtype == getattr(labels, name).dtype
        there = labels.area > 0  # a window says nothing of a colour without a cluster
        assert np.array_equal(own.mask[there], labels.mask[there])
        assert np.array_equal(own.corner[there], labels.corner[there])
        visible += labels.visible.tolist()
    assert 0.2 < np.mean(visible) < 0.95  # neither all nor none


def test_refuses_other_tensors(torch):
    areas = BatchedColourAreas(RGB)
    for wrong in (torch.zeros(2, 240, 320, 3), torch.zeros(2, 60, 80, 3, dtype=torch.uint8)):
        with pytest.raises(ObservationError, match="multiples of 8"):
            areas.find(wrong)
