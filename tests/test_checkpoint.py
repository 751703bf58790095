"""Checkpoints: whole, of the same config, and never a program."""

import hashlib
import os
import pickle
import sys
from collections import OrderedDict, deque
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from jointattn_mj.attention import AttentionConfig
from jointattn_mj.errors import CheckpointError
from jointattn_mj.recording import checkpoint
from jointattn_mj.recording.checkpoint import MAGIC, fingerprint, load, save
from jointattn_mj.scene.caregiver import Phase
from jointattn_mj.session import SessionConfig

CONFIG = SessionConfig(minutes=1, perception="truth")


def test_round_trip(tmp_path):
    generator = np.random.default_rng(1)
    generator.random(5)
    state = {
        "arrays": [np.arange(6.0).reshape(2, 3), np.zeros((0, 3), np.float32), np.asfortranarray(np.eye(3))],
        "scalars": (np.float32(1.5), np.int64(3), np.bool_(True), None, 1j, slice(1, 2)),
        "containers": [deque([1], maxlen=3), OrderedDict(a=1), {1, 2}, frozenset({3}), bytearray(b"x")],
        "ours": (AttentionConfig(motion_gain=2.0), Phase.LIFT, CONFIG),
        "path": Path("weights.npz"),
        "seed": np.random.SeedSequence(3).spawn(2)[1],
    }
    save(tmp_path / "c", (state, generator), CONFIG)
    loaded, again = load(tmp_path / "c", CONFIG)
    for name in ("scalars", "containers", "ours", "path"):
        assert loaded[name] == state[name]
    for old, new in zip(state["arrays"], loaded["arrays"], strict=True):
        np.testing.assert_array_equal(new, old)
        assert new.dtype == old.dtype
    assert loaded["seed"].generate_state(2).tolist() == state["seed"].generate_state(2).tolist()
    assert again.random() == generator.random()


def test_fingerprint_knows_every_option():
    """Deep ones too. What is equal as a config is the same."""
    robot = CONFIG.robot
    others = [
        replace(CONFIG, seed=1),
        replace(CONFIG, start_from=Path("weights.npz")),
        replace(CONFIG, robot=replace(robot, attention=replace(robot.attention, motion_cues=False))),
        replace(CONFIG, world=replace(CONFIG.world, scene=replace(CONFIG.world.scene, caregiver="noa"))),
        replace(CONFIG, truth=replace(CONFIG.truth, face_noise_px=0.5600001)),
    ]
    prints = [fingerprint(config) for config in (CONFIG, *others)]
    assert len(set(prints)) == len(prints)
    assert fingerprint(SessionConfig(minutes=1.0, perception="truth")) == prints[0]


def test_another_config(tmp_path):
    save(tmp_path / "c", [1], CONFIG)
    assert load(tmp_path / "c", CONFIG) == [1]
    with pytest.raises(CheckpointError, match="another config"):
        load(tmp_path / "c", replace(CONFIG, seed=1))


def test_no_file(tmp_path):
    with pytest.raises(CheckpointError, match="no checkpoint"):
        load(tmp_path / "c", CONFIG)
    with pytest.raises(CheckpointError, match="cannot read"):
        load(tmp_path, CONFIG)


@pytest.fixture(scope="module")
def kept(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("kept") / "c"
    save(path, {"x": np.arange(50)}, CONFIG)
    return path


@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_damage(kept, tmp_path, data):
    """Any byte that is changed, and any cut, is noticed."""
    whole = kept.read_bytes()
    place = data.draw(st.integers(0, len(whole) - 1))
    path = tmp_path / "c"
    if data.draw(st.booleans()):
        path.write_bytes(whole[:place])
    else:
        path.write_bytes(whole[:place] + bytes([whole[place] ^ data.draw(st.integers(1, 255))]) + whole[place + 1 :])
    with pytest.raises(CheckpointError, match="damaged"):
        load(path, CONFIG)
    assert load(kept, CONFIG)["x"][-1] == 49


def forge(path: Path, pickled: bytes) -> None:
    """A checkpoint that is formally right, with a pickle of somebody else's."""
    body = fingerprint(CONFIG).encode() + pickled
    path.write_bytes(MAGIC + hashlib.sha256(body).hexdigest().encode() + body)


def call(module: str, name: str, argument: str) -> bytes:
    """A pickle that calls module.name(argument); protocol 4 follows dots in the name."""

    def text(value: str) -> bytes:
        encoded = value.encode()
        return b"\x8c" + bytes([len(encoded)]) + encoded

    return b"\x80\x04" + text(module) + text(name) + b"\x93" + text(argument) + b"\x85R."


class Command:
    """What pickles into a call of os.system."""

    def __init__(self, command: str):
        self.command = command

    def __reduce__(self):
        return os.system, (self.command,)


def test_the_forgery_works_elsewhere():
    assert pickle.loads(call("builtins", "len", "four")) == 4
    assert pickle.loads(call("jointattn_mj.recording.files", "os.path.basename", "a/b")) == "b"


@pytest.mark.parametrize(
    ("module", "name"),
    [
        ("os", "system"),
        ("posix", "system"),
        ("subprocess", "getoutput"),
        ("builtins", "eval"),
        ("builtins", "exec"),
        ("builtins", "getattr"),
        ("numpy", "load"),
        ("numpy.testing", "runstring"),
        ("numpy.f2py.crackfortran", "myeval"),
        ("collections", "namedtuple"),
        ("jointattn_mj.recording.files", "os.system"),  # what our modules have imported is not ours
        ("jointattn_mj.recording.files", "Path.unlink"),
        ("jointattn_mj.recording.checkpoint", "pickle.loads"),
        ("jointattn_mj.cli", "main"),
        ("jointattn_mj.recording.files", "write_whole"),
        ("jointattn_mj_elsewhere", "anything"),
    ],
)
def test_programs_are_refused(tmp_path, module, name):
    marker = tmp_path / "marker"
    forge(tmp_path / "c", call(module, name, f"touch {marker}"))
    with pytest.raises(CheckpointError, match=f"{module}.{name} does not belong"):
        load(tmp_path / "c", CONFIG)
    assert not marker.exists()


def test_a_pickled_command_is_refused(tmp_path):
    marker = tmp_path / "marker"
    forge(tmp_path / "c", pickle.dumps([1, Command(f"touch {marker}")]))
    with pytest.raises(CheckpointError, match=r"system does not belong"):
        load(tmp_path / "c", CONFIG)
    assert not marker.exists()


@pytest.mark.parametrize(
    "pickled",
    [
        b"",
        b"no pickle",
        pickle.dumps([1])[:-1],
        call("jointattn_mj.attention", "NoSuchClass", "x"),
        call("jointattn_mj.nowhere", "Class", "x"),
        call("jointattn_mj.attention", "AttentionSelector", "too few arguments"),
    ],
)
def test_another_versions_pickle(tmp_path, pickled):
    """Whatever unpickling makes of it, it is one named error."""
    forge(tmp_path / "c", pickled)
    with pytest.raises(CheckpointError, match="another version"):
        load(tmp_path / "c", CONFIG)


def test_no_module_is_imported_for_a_foreign_name(tmp_path):
    forge(tmp_path / "c", call("antigravity", "fly", "x"))
    with pytest.raises(CheckpointError):
        load(tmp_path / "c", CONFIG)
    assert "antigravity" not in sys.modules


def test_it_says_what_it_is(tmp_path):
    save(tmp_path / "c", [1], CONFIG)
    assert (tmp_path / "c").read_bytes().startswith(checkpoint.MAGIC)
