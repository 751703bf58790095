"""Many worlds drawn at once: on the processor, two at a time. Warp and OpenGL never meet in one process."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from jointattn_mj.errors import ConfigError, ExtraError, ObservationError
from jointattn_mj.scene import gl
from jointattn_mj.scene.batched_eye import BatchedEye, pixel_order
from jointattn_mj.scene.batched_parts import PART_HEIGHT, PART_WIDTH, BatchedParts
from jointattn_mj.scene.model import build_model


def test_order_of_pixels():
    assert pixel_order(6, 4, ()).tolist() == list(range(24))
    order = pixel_order(8, 4, ((4, 2),))
    assert sorted(order) == list(range(32))
    assert order[:8].tolist() == [0, 1, 2, 3, 8, 9, 10, 11]  # the first tile, row by row
    assert order[8:16].tolist() == [4, 5, 6, 7, 12, 13, 14, 15]
    cut = pixel_order(5, 3, ((4, 2),))
    assert sorted(cut) == list(range(15))
    assert cut[8:10].tolist() == [4, 9]  # what the border leaves of the second


def test_needs_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "warp", None)
    with pytest.raises(ExtraError, match=r"jointattn-mj\[gpu\]"):
        BatchedEye(build_model(), 2)
    with pytest.raises(ConfigError, match="`worlds` must be 1 or more; got 0"):
        BatchedEye(build_model(), 0)


@pytest.fixture(scope="module")
def model():
    pytest.importorskip("mujoco_warp")
    return build_model()


@pytest.fixture
def poses(model):
    """The scene as it is compiled, and with the head turned by a fifth of a radian."""
    angles = np.tile(model.qpos0, (2, 1))
    angles[1, model.joint("robot/pan").qposadr[0]] = 0.2
    bodies = [model.body(body).pos for body in range(model.nbody) if model.body(body).mocapid[0] >= 0]
    return angles, np.tile(bodies, (2, 1, 1))


@pytest.mark.gpu
def test_images(model, poses):
    torch = pytest.importorskip("torch")
    tiled, by_row = (BatchedEye(model, 2, device="cpu", tiles=tiles) for tiles in (((8, 4), (32, 32)), ()))
    for eye in (tiled, by_row):
        eye.set_poses(*poses)
        eye.draw()
    images = tiled.images()
    assert images.shape == (2, 240, 320, 3)
    assert np.array_equal(images, by_row.images())
    assert np.array_equal(images, tiled.tensor().numpy())
    assert tiled.tensor().dtype == torch.uint8
    shift = round(160 / np.tan(np.radians(30.95)) * np.tan(0.2))  # what was in the middle is to the right now
    before, after = images[0, :, 150:170].astype(int), images[1, :, 150 + shift : 170 + shift].astype(int)
    assert np.abs(before - after).mean() < 0.25 * np.abs(before - images[1, :, 150:170]).mean()


@pytest.mark.gpu
def test_parts_are_those_of_whole_images(model, poses):
    whole = BatchedEye(model, 2, device="cpu")
    whole.set_poses(*poses)
    whole.draw()
    corners = np.stack(np.meshgrid(range(160, 320, PART_WIDTH), range(48, 192, PART_HEIGHT)), -1).reshape(-1, 2)
    parts = BatchedParts(model, len(corners) + 1, device="cpu")
    parts.angles[:], parts.objects[:] = poses[0][1], poses[1][1]
    parts.set_corners(corners)
    parts.draw()
    pixels = parts.images()
    assert not pixels[-1].any(), "a slot that nobody wants shows nothing"
    drawn = np.zeros((240, 320, 3), np.uint8)
    for part, (x, y) in zip(pixels, corners, strict=False):
        drawn[y : y + PART_HEIGHT, x : x + PART_WIDTH] = part
    off = np.abs(drawn[48:192, 160:].astype(int) - whole.images()[1, 48:192, 160:])
    assert (off.max(2) > 2).sum() < 5


@pytest.mark.gpu
def test_what_it_refuses(model, poses):
    eye = BatchedEye(model, 2, 16, 16, device="cpu")
    with pytest.raises(ObservationError, match="objects"):
        eye.set_poses(poses[0], poses[1][:1])
    with pytest.raises(ConfigError, match="graphics card"):
        eye.capture()


@pytest.mark.gpu
@pytest.mark.skipif(not any(map(gl.available, gl.LIBRARIES)), reason="no OpenGL library to render with")
def test_measuring(model, tmp_path):
    words = "-m tools.gpu_eye --worlds 2 --sizes 320x240 --device cpu --blocks 2 --block-seconds 0.01 --out"
    subprocess.run([sys.executable, *words.split(), tmp_path / "eye.json"], check=True, cwd=Path(__file__).parents[2])
    figures = json.loads((tmp_path / "eye.json").read_text())
    assert figures["to_opengl"]["images"] == 2
    assert 0 < figures["to_opengl"]["mean"] < 1
    assert [row["tiles"] for row in figures["rows"]] == [[[8, 4]], []]
    for row in figures["rows"]:
        median, low, high = row["images_per_s"]
        assert 0 < low <= median <= high
        assert row["draw_us"][0] * median == pytest.approx(1e6)
