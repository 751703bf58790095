"""Frames without a decision, passed many at a time: everything is as it is frame by frame, to the bit."""

import random
from dataclasses import replace
from operator import attrgetter

import mujoco
import numpy as np
import pytest

from jointattn_mj.errors import NotFiniteError
from jointattn_mj.gaze_following import undecided
from jointattn_mj.gaze_following.agent import FamiliariseConfig, GazeFollower
from jointattn_mj.gaze_following.presets import PRESETS
from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.gaze_following.tables import FrameTable
from jointattn_mj.gaze_following.varied_session import VariedSessionConfig, VariedSessionRun
from jointattn_mj.io import checkpoint
from jointattn_mj.scene import world as scene_world
from jointattn_mj.scene.caregiver import TransferScript
from jointattn_mj.scene.world import WorldConfig, WorldObservation

STATE = SessionConfig(minutes=1.5, seed=11, perception="state")
CLOSED = replace(STATE, world=WorldConfig(dynamics="closed_form"))


def with_gaze(config=STATE, **options):
    return replace(config, robot=replace(config.robot, gaze=replace(config.robot.gaze, **options)))


def begun(config, kind=SessionRun):
    config = replace(config, robot=replace(config.robot, familiarise=FamiliariseConfig(minutes=0.1)))
    session = kind(config)
    session.begin()
    return session


def advance(session, end):
    while session.frame < end:
        session.advance(end - session.frame)


def frozen(session, path):
    checkpoint.save(path, session, session.config, type(session).__module__)
    return path.read_bytes()


@pytest.mark.parametrize(
    ("config", "kind"),
    [
        (STATE, SessionRun),
        (replace(STATE, robot=PRESETS["cross_situational"]), SessionRun),
        (with_gaze(feedback_frames=(), wait_for_still_face=True), SessionRun),
        (with_gaze(feedback_frames=(0, 5, 40, 7), shift_frames=12, attends="centred"), SessionRun),
        (VariedSessionConfig(minutes=1, seed=3, perception="state", variation="people+pace"), VariedSessionRun),
        (VariedSessionConfig(minutes=1, seed=3, perception="state", variation="all"), VariedSessionRun),
        (CLOSED, SessionRun),
        (with_gaze(CLOSED, feedback_frames=(0, 5, 40, 7), shift_frames=1, attends="centred"), SessionRun),
        (VariedSessionConfig(minutes=1, seed=3, perception="state", variation="people+pace", world=CLOSED.world),
         VariedSessionRun),
    ],
)  # fmt: skip
def test_a_session_is_the_same_frame_by_frame(config, kind, tmp_path):
    one_by_one, at_once, length = begun(config, kind), begun(config, kind), random.Random(1)
    while one_by_one.frame < one_by_one.total:
        frames = min(length.choice([1, 2, 5, 17, 30, 200]), one_by_one.total - one_by_one.frame)
        for _ in range(frames):
            one_by_one.step()
        advance(at_once, one_by_one.frame)
        assert frozen(one_by_one, tmp_path / "a.bin") == frozen(at_once, tmp_path / "b.bin"), one_by_one.frame
    assert one_by_one.frames.table().equals(at_once.frames.table())
    assert one_by_one.shifts.table().equals(at_once.shifts.table())
    assert len(one_by_one.shifts) > 10


def test_a_session_begins_with_a_frame_alone_and_goes_on_as_ever(tmp_path):
    one_by_one, at_once = begun(STATE), begun(STATE)
    for _ in range(5):
        one_by_one.step()
    assert undecided.pass_by(at_once, 5) == 0
    advance(at_once, 1)
    assert undecided.pass_by(at_once, 4) == 4
    assert frozen(one_by_one, tmp_path / "a.bin") == frozen(at_once, tmp_path / "b.bin")


def test_a_session_from_images_passes_by_while_the_head_turns(tmp_path):
    config = SessionConfig(minutes=0.1, seed=2)
    one_by_one, at_once = begun(config), begun(config)
    passed = 0
    while one_by_one.frame < one_by_one.total:
        before = at_once.frame
        at_once.advance(at_once.total)
        passed += at_once.frame - before > 1
        while one_by_one.frame < at_once.frame:
            one_by_one.step()
    assert frozen(one_by_one, tmp_path / "a.bin") == frozen(at_once, tmp_path / "b.bin")
    assert passed > 2


def test_most_frames_are_passed_by():
    session, alone = begun(STATE), 0
    while session.frame < session.total:
        if not undecided.pass_by(session, 30):
            session.step()
            alone += 1
    assert alone < 0.15 * session.total


def test_in_closed_form_a_session_decides_what_it_does_in_the_physics():
    simulated, closed = begun(STATE), begun(CLOSED)
    simulated.finish()
    closed.finish()
    for name in ("launch_s", "landing_s", "source", "chosen", "reached", "commanded_by", "learned", "success"):
        np.testing.assert_array_equal(closed.shifts.column(name), simulated.shifts.column(name), name)
    tables = [session.shifts.rows.read() for session in (simulated, closed)]
    np.testing.assert_allclose(tables[1], tables[0], rtol=0, atol=1e-3)  # face patterns are rounded to float32
    assert len(closed.shifts) > 40
    for name, learned in simulated.weights().items():
        np.testing.assert_allclose(closed.weights()[name], learned, rtol=0, atol=1e-3)


def test_in_closed_form_a_head_that_settles_is_passed_by():
    session, settling = begun(CLOSED), 0
    while session.frame < session.total:
        shift = session.robot.shift
        if not undecided.pass_by(session, 30):
            settling += shift is not None and session.robot.commanded_after(0)
            session.step()
    assert settling <= len(session.shifts) + 1  # the landing itself


def test_at_most_so_many_frames_are_simulated():
    session = begun(STATE)
    for most in (1, 4, 9, 1000):
        before = session.frame
        session.advance(most)
        assert 1 <= session.frame - before <= most
    session.advance(10**9)
    while session.frame < session.total:
        session.advance(10**9)
    assert session.frame == session.total == session.frames.frames


def test_a_watcher_sees_every_frame():
    session, seen = begun(STATE), []
    while session.frame < 300:
        session.advance(30, lambda session: seen.append(session.frame))
    assert seen == list(range(300))


def test_own_parts_are_asked_in_every_frame():
    class Counting(GazeFollower):
        acted = 0

        def act(self, observation):
            self.acted += 1
            return super().act(observation)

    class WithCounting(SessionRun):
        def new_robot(self, perceiver, seed):
            return Counting(self.config.robot, perceiver, len(self.config.world.scene.objects), seed)

    class Stepping(SessionRun):
        stepped = 0

        def step(self, watch=None):
            self.stepped += 1
            super().step(watch)

    session = begun(STATE, WithCounting)
    advance(session, 200)
    assert session.robot.acted == 200
    session = begun(STATE, Stepping)
    advance(session, 200)
    assert session.stepped == 200


class Reacting(TransferScript):
    """Turns its head with the robot's, which it asks in every frame."""

    robot_world = None

    def advance(self):
        super().advance()
        self.joints = self.joints + 0.1 * self.robot_world.head_angles()[0]


class Inexact(SessionRun):
    """Its robot takes its head to be 3 degrees beside where it is."""

    class Observation(WorldObservation):
        @property
        def head_angles(self):
            return super().head_angles + np.radians(3)

    def new_observation(self):
        return self.Observation(self.world)


class Counted(FrameTable):
    added = 0

    def add(self, *parts):
        self.added += 1
        super().add(*parts)


class Counting(SessionRun):
    def new_frames(self):
        return Counted(self.names[:-1], 4.0, 0.1)


def reacting(config):
    session = begun(config)
    session.world.caregiver.__class__ = Reacting
    session.world.caregiver.robot_world = session.world
    return session


@pytest.mark.parametrize("make", [lambda config: begun(config, Inexact), reacting])
def test_own_observations_and_caregivers_have_their_way(make):
    one_by_one, at_once = make(STATE), make(STATE)
    for _ in range(400):
        one_by_one.step()
    advance(at_once, 400)
    assert one_by_one.frames.table().equals(at_once.frames.table())


def test_in_closed_form_a_world_says_itself_whether_the_head_moves():
    def slow():
        session = begun(CLOSED)
        moves = session.world.head_moves
        session.world.head_moves = lambda: session.frame % 7 != 0 and moves()
        return session

    one_by_one, at_once = slow(), slow()
    for _ in range(600):
        one_by_one.step()
    advance(at_once, 600)
    assert one_by_one.shifts.table().equals(at_once.shifts.table())
    assert one_by_one.frames.table().equals(at_once.frames.table())


def test_an_own_table_gets_every_frame():
    session = begun(STATE, Counting)
    advance(session, 200)
    assert session.frames.added == 200


def calls_of(part, name, go):
    """The frames in which a method is called that has been put into a part of a session in place of its own."""
    session, calls = begun(STATE), []
    owner = attrgetter(part)(session) if part else session
    method = getattr(owner, name)

    def noting(*arguments, **named):
        calls.append(session.frame)
        return method(*arguments, **named)

    setattr(owner, name, noting)
    go(session)
    return calls


@pytest.mark.parametrize(
    "path",
    [
        "step", "world.step", "world.before_step", "world.head_moves", "world.caregiver.advance",
        "world.caregiver._play", "frames.add", "robot.act", "robot._choose", "robot._turn", "robot._hold",
        "robot._pair", "robot.perceiver.perceive", "robot.attention.advance", "robot.attention.consider",
    ],
)  # fmt: skip
def test_a_method_replaced_in_a_part_is_called_as_frame_by_frame(path):
    part, _, name = path.rpartition(".")
    one_by_one = calls_of(part, name, lambda session: [session.step() for _ in range(400)])
    assert calls_of(part, name, lambda session: advance(session, 400)) == one_by_one != []


def test_what_python_does_within_mujocos_steps_is_heard():
    """What it raises gets through MuJoCo's binding alone; from compiled code, the process would end."""
    session = begun(STATE)
    assert session.world.runs

    def refuse(model, data):
        raise RuntimeError("no")

    mujoco.set_mjcb_control(refuse)
    try:
        assert not session.world.runs
        with pytest.raises(RuntimeError, match="no"):
            advance(session, 200)
    finally:
        mujoco.set_mjcb_control(None)
    assert session.world.runs


def test_a_world_runs_by_commands_for_its_head_alone():
    session = begun(STATE)
    with pytest.raises(ValueError, match=r"expected commands \(k, 2\), rad; got \(5, 1\)"):
        session.world.run(np.zeros((5, 1)))


def test_a_tape_has_to_fit_its_world():
    session = begun(STATE)
    tape = session.world.run(np.zeros((5, 2)))
    with pytest.raises(ValueError, match="do not fit"):
        session.robot.perceiver.perceive_all(replace(tape, objects=tape.objects[:3]))


def test_without_the_steps_of_mujoco_it_goes_frame_by_frame(monkeypatch, tmp_path):
    expected = begun(STATE)
    advance(expected, 300)
    monkeypatch.setattr(scene_world, "half_steps", lambda: None)
    session = begun(STATE)
    assert not session.world.runs
    advance(session, 300)
    assert frozen(session, tmp_path / "a.bin") == frozen(expected, tmp_path / "b.bin")


def test_an_unstable_simulation_is_noticed_as_ever(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)  # MuJoCo leaves a log
    session = begun(STATE)
    session.world.data.qvel[:] = 1e12
    session.world.run(np.zeros((5, 2)))
    with pytest.raises(NotFiniteError, match="unstable"):
        session.world.check()


def test_the_methods_that_are_asked_for_are_those_that_are_named():
    named = [getattr(kind, name) for kind, names in undecided._NAMES.items() for name in names]
    assert named == list(undecided._methods())
