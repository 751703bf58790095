"""An eye server: requests of several processes are gathered, drawn in batches, and given back."""

import os
import sys
import threading
from contextlib import nullcontext
from multiprocessing import Pipe
from types import SimpleNamespace

import numpy as np
import pytest

from jointattn_mj.errors import ExtraError, GLError
from jointattn_mj.scene import eye_server
from jointattn_mj.scene.batched_parts import PART_HEIGHT, PART_WIDTH
from jointattn_mj.scene.eye_block import EyeBlock, EyeBlockLayout, PartsRequest
from jointattn_mj.scene.eye_client import EyeClient
from jointattn_mj.scene.model import SceneConfig

CORNERS = np.stack(np.meshgrid(range(0, 64, PART_WIDTH), range(0, 96, PART_HEIGHT)), -1).reshape(-1, 2)


class PaintedParts:
    """Stands in for a card: a part's colour says what pose it has and where it lies."""

    def __init__(self, model, slots, device=None):
        self.worlds, self.device = slots, SimpleNamespace(is_cuda=False)
        self.angles, self.objects = np.zeros((slots, 3), np.float32), np.zeros((slots, 2, 3), np.float32)
        self._pixels = np.zeros((slots, PART_WIDTH * PART_HEIGHT), np.uint32)

    def set_corners(self, corners):
        self._corners = corners.copy()

    def draw(self):
        x, y = self._corners.T.astype(np.uint32)
        red = (self.angles[: len(x), 0] + self.objects[: len(x), 1, 2]).astype(np.uint32)
        self._pixels[: len(x)] = (red << 16 | x << 8 | y)[:, None]

    def copy(self):
        self.copied = self._pixels.copy()

    def packed(self):
        return self.copied


@pytest.fixture
def clients(monkeypatch):
    """Two clients of a server that draws seven parts at once."""
    warp = SimpleNamespace(get_device=lambda name: SimpleNamespace(is_cuda=False), ScopedStream=nullcontext)
    monkeypatch.setattr(eye_server, "extra", lambda name, module: warp)
    monkeypatch.setattr(eye_server, "BatchedParts", PaintedParts)
    monkeypatch.setattr(eye_server, "build_model", lambda scene: None)
    pipes = [Pipe() for _ in range(2)]
    server = threading.Thread(target=eye_server.EyeServer([theirs for _, theirs in pipes], slots=7).run)
    server.start()
    yield [EyeClient(ours, images=2) for ours, _ in pipes]
    for ours, _ in pipes:
        ours.close()
    server.join(10)
    assert not server.is_alive(), "the server ends with its last client"


def request(red, corners=CORNERS):
    positions = np.zeros((2, 3))
    positions[1, 2] = 1
    return PartsRequest(SceneConfig(), np.array([red - 1.0, 0, 0]), positions, corners, np.zeros((96, 64, 3), np.uint8))


def expected(red, corners=CORNERS):
    image = np.zeros((96, 64, 3), np.uint8)
    for x, y in corners:
        image[y : y + PART_HEIGHT, x : x + PART_WIDTH] = red, x, y
    return image


def test_every_image_gets_its_own_parts(clients):
    sent = []
    for number, client in enumerate(clients):
        blocks = [client.open(request(0)) for _ in range(2)]
        for block in blocks:
            for few in (CORNERS[3:5], CORNERS):
                sent.append((request(10 * len(sent) + 1, few), few))
                assert not block.full
                block.add(sent[-1][0])
            assert block.full
            client.submit(block)
        assert {id(client.receive()[1]) for _ in blocks} == set(map(id, blocks)), number
        assert not any(block.requests for block in blocks)
    for asked, few in sent:
        red = int(asked.angles[0]) + 1
        assert np.array_equal(asked.image, expected(red, few))


def test_a_block_is_one_memory_and_leaves_no_file():
    layout = EyeBlockLayout(joints=3, objects=2, images=2, parts=4, pixels=PART_WIDTH * PART_HEIGHT)
    own = EyeBlock(layout)
    assert os.fstat(own.file).st_nlink == 0, "nothing is left even of a process that is killed"
    other = EyeBlock(layout, os.dup(own.file))
    os.close(own.file)
    os.close(other.file)
    other.pixels[:] = 7
    assert (own.pixels == 7).all()


def test_a_server_that_ends_says_why(monkeypatch):
    monkeypatch.setitem(sys.modules, "warp", None)
    ours, theirs = Pipe()
    monkeypatch.setattr(eye_server.signal, "signal", lambda *_: None)
    eye_server.serve_eyes([theirs])
    with pytest.raises(ExtraError, match=r"jointattn-mj\[gpu\]"):
        EyeClient(ours, 1).receive()
    theirs.close()
    with pytest.raises(GLError, match="has ended"):
        EyeClient(ours, 1).receive()


def test_a_server_that_is_gone_has_said_why_before(monkeypatch):
    def fail(*arguments):
        raise MemoryError("the card is full")

    ours, theirs = Pipe()
    warp = SimpleNamespace(config=SimpleNamespace(), LOG_WARNING=0)
    monkeypatch.setattr(eye_server, "extra", lambda name, module: warp)
    monkeypatch.setattr(eye_server, "EyeServer", fail)
    monkeypatch.setattr(eye_server.signal, "signal", lambda *_: None)
    eye_server.serve_eyes([theirs])
    theirs.close()
    with pytest.raises(GLError, match="has stopped: MemoryError: the card is full"):
        EyeClient(ours, 1).open(request(0))
    with pytest.raises(GLError, match="has ended"):
        EyeClient(ours, 1).open(request(0))
