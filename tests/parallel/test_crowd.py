"""Trials whose images one card draws: here on the processor, two at a time, in one process."""

import os
import sys
from dataclasses import replace

import numpy as np
import pytest

from jointattn_mj.errors import ConfigError, ExtraError, GLError
from jointattn_mj.gaze_following.agent import FamiliariseConfig
from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.parallel.crowd import Crowd, CrowdWorkerDied
from jointattn_mj.scene.world import WorldConfig


def test_what_it_needs(monkeypatch):
    with pytest.raises(ConfigError, match="got -1"):
        Crowd(-1)
    with pytest.raises(ConfigError, match="got 1, 0"):
        Crowd(1, 0)
    monkeypatch.setitem(sys.modules, "greenlet", None)
    with pytest.raises(ExtraError, match=r"greenlet: pip install 'jointattn-mj\[gpu\]'"):
        Crowd(1)


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
def test_the_end_of_the_eye_server_is_told_to_every_trial(backend):
    futures = [backend.submit(heads, seed) for seed in (1, 2, 3)]
    backend._children[0].kill()
    for future in futures:
        with pytest.raises(GLError, match="has ended"):
            future.result(timeout=600)


@pytest.mark.gpu
def test_the_death_of_a_worker(backend):
    lost = [backend.submit(die, 3), backend.submit(heads, 1)]
    for future in lost:
        with pytest.raises(CrowdWorkerDied):
            future.result(timeout=600)
    backend.restart()
    assert backend.submit(abs, -3).result(timeout=600) == 3
