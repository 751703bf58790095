"""An eye whose images another process draws: what it asks for, and what it makes of the answer."""

import os
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from jointattn_mj.errors import ConfigError, GLError
from jointattn_mj.scene import warp_eye
from jointattn_mj.scene.batched_parts import PART_HEIGHT, PART_WIDTH
from jointattn_mj.scene.dressing import Conditions, Lamp
from jointattn_mj.scene.model import SceneConfig
from jointattn_mj.scene.warp_eye import OwnServer, WarpEye, parts_drawn_by
from jointattn_mj.scene.world import World, WorldConfig

PARTS = 320 // PART_WIDTH * (240 // PART_HEIGHT)


@pytest.fixture
def asked():
    """Sizes of the requests; parts are painted white."""
    sizes = []

    def paint(request):
        sizes.append(len(request.corners))
        for x, y in request.corners:
            assert x % PART_WIDTH == y % PART_HEIGHT == 0
            request.image[y : y + PART_HEIGHT, x : x + PART_WIDTH] = 255

    with parts_drawn_by(paint):
        yield sizes


def world(draws):
    return World.build(WorldConfig(renderer="warp", draws=draws), np.random.SeedSequence(3))


def test_asks_for_what_has_changed(asked):
    with_changes = world("changes")
    assert isinstance(with_changes.eye, WarpEye)
    assert (with_changes.image() == 255).all()
    assert asked == [PARTS]
    images = []
    for _ in range(40):
        with_changes.step(np.zeros(2))
        images.append(with_changes.image())
    assert max(asked[1:]) < PARTS
    assert len(asked) <= 41
    with_changes.step(np.array([0.5, 0]))
    with_changes.image()
    assert asked[-1] == PARTS
    with_changes.close()


def test_asks_for_all_where_all_is_drawn(asked):
    whole = world("all")
    for _ in range(3):
        whole.step(np.zeros(2))
        whole.image()
    assert asked == [PARTS] * 3
    whole.close()


def test_looks_stay_as_compiled(asked):
    made = world("changes")
    with pytest.raises(ConfigError, match="need opengl"):
        made.vary(made.config, Conditions(lamp=Lamp(azimuth_deg=5.0)))
    with pytest.raises(ConfigError, match="need opengl"):
        made.vary(replace(made.config, scene=SceneConfig(quality="high")), Conditions())
    made.close()


def test_after_a_failure_all_is_drawn(asked):
    made = world("changes")
    made.image()
    made.step(np.zeros(2))

    def fail(request):
        raise GLError("no image today")

    with parts_drawn_by(fail), pytest.raises(GLError):
        for _ in range(40):
            made.step(np.zeros(2))
            made.image()
    made.image()
    assert asked == [PARTS] * 2
    made.close()


@pytest.fixture
def servers(monkeypatch):
    """Connections to the servers of this process, which are not started."""
    started = []

    def start(module, function, connections):
        (connection,) = connections
        started.append(connection)
        return SimpleNamespace(kill=connection.close, wait=lambda: None)

    monkeypatch.setattr(warp_eye, "start_child", start)
    yield started
    monkeypatch.setattr(OwnServer, "_now", None)
    for connection in started:
        connection.close()


@pytest.mark.parametrize("error", [GLError, KeyboardInterrupt])
def test_a_server_that_failed_is_followed_by_another(servers, monkeypatch, error):
    """What the first would have answered later is no answer to the next request."""

    def fail(client):
        raise error

    made = world("all")
    for number in (1, 2):
        with monkeypatch.context() as patched, pytest.raises(error):
            patched.setattr(warp_eye.EyeClient, "receive", fail)
            made.image()
        assert len(servers) == number
        assert servers[-1].closed
    made.close()


def test_a_forked_process_leaves_the_server_to_its_parent(servers, monkeypatch):
    monkeypatch.setattr(warp_eye.EyeClient, "receive", lambda client: client._blocks[0][1].deliver(PART_WIDTH))
    made = world("all")
    made.image()
    assert OwnServer._now is not None
    child = os.fork()
    if not child:
        os._exit(0 if OwnServer._now is None else 1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    made.image()
    assert len(servers) == 1
    made.close()
