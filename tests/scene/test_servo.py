"""The closed form of what moves, beside MuJoCo's physics."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from jointattn_mj.scene.looker import LookingWorld
from jointattn_mj.scene.servo import Servos, steps_to_rest, turn
from jointattn_mj.scene.world import World, WorldConfig

CLOSED = WorldConfig(dynamics="closed_form")


def pair(kind=World):
    """The same world by MuJoCo and in closed form."""
    return [kind.build(replace(CLOSED, dynamics=way), np.random.SeedSequence(3)) for way in ("mujoco", "closed_form")]


def commands(count, seed=0):
    """Commands that change every 40 steps."""
    return np.repeat(np.random.default_rng(seed).uniform(-0.5, 0.5, (count // 40 + 1, 2)), 40, axis=0)[:count]


@pytest.mark.parametrize("kind", [World, LookingWorld])
def test_bodies_move_as_in_the_physics(kind):
    simulated, closed = pair(kind)
    for command in commands(3000):
        for world in (simulated, closed):
            world.step(command)
        np.testing.assert_allclose(closed.head_angles(), simulated.head_angles(), rtol=0, atol=1e-13)
        np.testing.assert_allclose(closed.head_velocity(), simulated.head_velocity(), rtol=0, atol=1e-12)
        np.testing.assert_allclose(closed.face_angles(), simulated.face_angles(), rtol=0, atol=1e-10)
        np.testing.assert_allclose(closed.data.qpos, simulated.data.qpos, rtol=0, atol=1e-7)
        np.testing.assert_array_equal(closed.candidate_points(), simulated.candidate_points())
    assert closed.data.time == pytest.approx(simulated.data.time)
    np.testing.assert_allclose(closed.data.xpos, simulated.data.xpos, rtol=0, atol=1e-7)
    close = np.abs(closed.image().astype(int) - simulated.image()) <= 1
    assert close.mean() > 0.9999


def test_joints_are_just_where_the_script_has_them():
    world = World.build(CLOSED, np.random.SeedSequence(1))
    for command in commands(500):
        world.step(command)
        np.testing.assert_array_equal(world._script_angles, world.caregiver.joints)


def test_many_steps_are_those_one_by_one():
    one_by_one, at_once = (World.build(CLOSED, np.random.SeedSequence(2)) for _ in range(2))
    done, given = 0, commands(2000)
    for count in (1, 3, 17, 200, 5, 600):
        seen = []
        for command in given[done : done + count]:
            seen.append(one_by_one.now())
            one_by_one.step(command)
        tape = at_once.run(given[done : done + count])
        for name in ("doing", "head", "face", "face_speeds"):
            parts = [getattr(frame, name) for frame in seen]
            np.testing.assert_array_equal(getattr(tape, name), np.concatenate(parts))
        np.testing.assert_array_equal(tape.objects[1:], np.concatenate([frame.objects[1:] for frame in seen]))
        for name in ("qpos", "qvel", "ctrl", "mocap_pos", "xpos", "time"):
            np.testing.assert_array_equal(getattr(at_once.data, name), getattr(one_by_one.data, name))
        done += count


@pytest.mark.parametrize("dynamics", ["mujoco", "closed_form"])
def test_no_step_changes_nothing(dynamics):
    world = World.build(replace(CLOSED, dynamics=dynamics), np.random.SeedSequence(2))
    world.run(commands(50))
    before = {name: np.copy(getattr(world.data, name)) for name in ("qpos", "qvel", "ctrl", "mocap_pos", "time")}
    around = np.full((3, 2), 7.0)
    assert not len(world.run(around[1:1]).head)
    for name, value in before.items():
        np.testing.assert_array_equal(getattr(world.data, name), value)


def test_a_world_runs_whatever_mujoco_would_call():
    world = World.build(CLOSED, np.random.SeedSequence(2))
    mujoco.set_mjcb_control(lambda model, data: None)
    try:
        assert world.runs
    finally:
        mujoco.set_mjcb_control(None)


def test_the_end_of_a_turn_is_foreseen():
    world = World.build(CLOSED, np.random.SeedSequence(0))
    given = np.vstack([np.linspace(0, 0.3, 20)[:, None] * [1, -0.5], np.tile([0.3, -0.15], (60, 1))])
    foreseen = world.steps_to_rest(given, 20)
    for command in given[:20]:
        world.step(command)
    moves = []
    for command in given[20:]:
        moves.append(world.head_moves())
        world.step(command)
    assert foreseen == 20 + moves.index(False) > 20
    assert not world.steps_to_rest(given[-1:].repeat(5, axis=0), 0)


def test_a_head_that_goes_on_moving_takes_all_steps():
    servos = Servos.of_model(World.build(CLOSED, np.random.SeedSequence(0)).model)
    angles, speeds = np.zeros((1, 2)), np.zeros((1, 2))
    given = np.linspace(0, 1, 12)[:, None] * np.ones(2)
    assert steps_to_rest(servos, angles, speeds, given, 3, 0.01) == 12
    assert not angles.any()
    assert not speeds.any()


def test_heads_turn_each_by_itself():
    servos = Servos.of_model(World.build(CLOSED, np.random.SeedSequence(0)).model)
    rng = np.random.default_rng(0)
    angles, speeds, given = rng.uniform(-1, 1, (3, 5, 2))
    alone = [(angles[head : head + 1].copy(), speeds[head : head + 1].copy()) for head in range(5)]
    turn(servos, angles, speeds, given, 7)
    for head, (angle, speed) in enumerate(alone):
        turn(servos, angle, speed, given[head : head + 1], 7)
        np.testing.assert_array_equal(angle[0], angles[head])
        np.testing.assert_array_equal(speed[0], speeds[head])
