"""Trials whose images one card draws: here on the processor, two at a time, in one process."""

import os
import pickle
import sys
import threading
from dataclasses import replace
from multiprocessing import Pipe
from multiprocessing.reduction import recv_handle
from types import SimpleNamespace

import numpy as np
import pytest

from jointattn_mj.errors import ConfigError, ExtraError, GLError, SweepError
from jointattn_mj.gaze_following.agent import FamiliariseConfig
from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.parallel import crowd
from jointattn_mj.parallel.crowd import ALL, Crowd, CrowdWorkerDied
from jointattn_mj.parallel.crowd_worker import CrowdWorker
from jointattn_mj.scene import warp_eye
from jointattn_mj.scene.eye_block import PartsRequest
from jointattn_mj.scene.eye_client import DrawBlock
from jointattn_mj.scene.model import SceneConfig
from jointattn_mj.scene.world import WorldConfig


def test_what_it_needs(monkeypatch):
    with pytest.raises(ConfigError, match="got -1"):
        Crowd(-1)
    with pytest.raises(ConfigError, match="got 1, 0"):
        Crowd(1, 0)
    monkeypatch.setitem(sys.modules, "greenlet", None)
    with pytest.raises(ExtraError, match=r"greenlet: pip install 'jointattn-mj\[gpu\]'"):
        Crowd(1)


@pytest.fixture
def workers(monkeypatch):
    """A crowd of two processes that are not started, and their ends of the connections for trials."""
    ends = []

    def start(module, function, connections, environment=None):
        if function == "work":
            ends.append(connections[0])
        return SimpleNamespace(kill=connections[0].close, wait=lambda: None)

    monkeypatch.setattr(crowd, "find_spec", lambda module: True)
    monkeypatch.setattr(crowd, "start_child", start)
    made = Crowd(jobs=2, at_once=4)
    yield made, ends
    made.close()


def test_trials_after_a_death_are_lost_too(workers):
    """Those that the process was given last, and those that another would compute, to which nobody listens any more."""
    made, ends = workers
    lost = [made.submit(abs, number) for number in range(2)]
    ends[0].close()
    for future in lost:
        with pytest.raises(CrowdWorkerDied):
            future.result(timeout=10)
    with pytest.raises(CrowdWorkerDied):
        made.submit(abs, 2)
    made.restart()
    future = made.submit(abs, 3)
    for end in ends[2:]:
        end.close()
    with pytest.raises(CrowdWorkerDied):
        future.result(timeout=10)


def test_no_trial_goes_on_without_the_eye_server(workers):
    made, ends = workers
    lost = [made.submit(abs, number) for number in range(2)]
    ends[1].send((ALL, None, GLError("no card")))
    for future in lost:
        with pytest.raises(SweepError, match="no trial can go on: no card"):
            future.result(timeout=10)
    with pytest.raises(SweepError, match="no card"):
        made.submit(abs, 2)


def test_results_and_errors(workers):
    made, ends = workers
    first, second = made.submit(abs, -1), made.submit(abs, -2)
    for end in ends:
        assert end.recv() == 4
        number, packed = end.recv()
        function, arguments = pickle.loads(packed)
        end.send((number, function(*arguments), None) if number == 1 else (number, None, ValueError("bad")))
    assert first.result(timeout=10) == 1
    with pytest.raises(ValueError, match="bad"):
        second.result(timeout=10)


def look(times):
    """Asks for so many images."""
    for _ in range(times):
        part = np.zeros((1, 2), int)
        request = PartsRequest(SceneConfig(), np.zeros(3), np.zeros((2, 3)), part, np.zeros((96, 64, 3), np.uint8))
        warp_eye._draw_parts.get()(request)
    return times


@pytest.mark.gpu
@pytest.mark.parametrize("drawn", [0, 1, 2])
def test_a_worker_ends_with_the_eye_server(drawn):
    """Also when it learns of that end by asking, while no image is drawn."""
    pytest.importorskip("greenlet")
    (mine, theirs), (eyes, server) = Pipe(), Pipe()

    def serve():
        for _ in range(drawn):
            while not isinstance(message := server.recv(), DrawBlock):
                recv_handle(server)
            server.send(message.number)
        server.close()

    thread = threading.Thread(target=serve)
    thread.start()
    for number in (1, 2, 3):
        mine.send((number, pickle.dumps((look, (number,)))))
    with pytest.raises(GLError, match="has ended"):
        CrowdWorker(theirs, eyes, at_once=4).run()
    thread.join()


def heads(seed):
    """Where the head points in the first second and a half."""
    config = SessionConfig(minutes=0.02, seed=seed, world=WorldConfig(renderer="warp", draws="changes"))
    session = SessionRun(replace(config, robot=replace(config.robot, familiarise=FamiliariseConfig(minutes=0.005))))
    session.begin()
    path = []
    while session.frame < session.total:
        session.step()
        path.append(session.world.head_angles())
    image = session.world.image().copy()
    session.close()
    return np.array(path), image


def die(number):
    os._exit(number)


@pytest.fixture
def backend():
    for module in ("greenlet", "mujoco_warp"):
        pytest.importorskip(module)
    made = Crowd(jobs=1, at_once=2)
    yield made
    made.close()


@pytest.mark.gpu
def test_trials_that_take_turns_come_out_as_alone(backend):
    together = [backend.submit(heads, seed) for seed in (1, 2, 3)]
    assert backend.slots() == 2
    results = [future.result(timeout=600) for future in together]
    path, image = heads(2)
    assert np.array_equal(results[1][0], path)
    assert np.array_equal(results[1][1], image)
    assert not np.array_equal(results[0][1], image)


@pytest.mark.gpu
def test_the_end_of_the_eye_server_ends_all(backend):
    futures = [backend.submit(heads, seed) for seed in (1, 2, 3)]
    backend._children[0].kill()
    for future in futures:
        with pytest.raises(SweepError, match="no trial can go on: the process that draws images has ended"):
            future.result(timeout=600)
    with pytest.raises(SweepError):
        backend.submit(heads, 4)
    backend.restart()
    assert backend.submit(abs, -3).result(timeout=600) == 3


@pytest.mark.gpu
def test_the_death_of_a_worker(backend):
    lost = [backend.submit(die, 3), backend.submit(heads, 1)]
    for future in lost:
        with pytest.raises(CrowdWorkerDied):
            future.result(timeout=600)
    backend.restart()
    assert backend.submit(abs, -3).result(timeout=600) == 3
