"""Checkpoints: whole, of the same config, plain data, and never a program."""

import copy
import hashlib
import io
import json
import os
import pickle
import sys
import zipfile
from collections import OrderedDict, defaultdict, deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from jointattn_mj.contingency.online.events import Event
from jointattn_mj.development.table.config import TableDevelopmentConfig
from jointattn_mj.errors import CheckpointError
from jointattn_mj.gaze_following.agent import FamiliariseConfig, RobotConfig
from jointattn_mj.gaze_following.attention import AttentionConfig, AttentionSelector
from jointattn_mj.gaze_following.gate import HeadShift
from jointattn_mj.gaze_following.learners import LearnerConfig, LinearLearner
from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.io.checkpoint import FORMAT, fingerprint, load, save
from jointattn_mj.io.parts import PARTS, class_named
from jointattn_mj.scene.caregiver import Phase

CONFIG = SessionConfig(minutes=1, perception="state", robot=RobotConfig(familiarise=FamiliariseConfig(minutes=0.02)))


def fill(file: zipfile.ZipFile, members: dict[str, bytes], compression: int) -> None:
    for name, content in members.items():
        file.writestr(name, content, compression)


def sealed(members: dict[str, bytes], compression: int = zipfile.ZIP_STORED, number: int = FORMAT) -> bytes:
    """A checkpoint that is formally right, with contents of somebody else's."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as file:
        fill(file, members, compression)
        file.comment = b"jointattn checkpoint %d sha256=" % number + b"0" * 64
    content = buffer.getvalue()[:-64]
    return content + hashlib.sha256(content).hexdigest().encode()


def members_of(path: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(path) as file:
        return {name: file.read(name) for name in file.namelist()}


def header(config: Any = CONFIG) -> bytes:
    return json.dumps({"format": FORMAT, "config": fingerprint(config), "versions": {}}).encode()


def forge(path: Path, entries: list[Any], root: Any = (0,), config: Any = CONFIG, **arrays: bytes) -> Path:
    state = json.dumps({"root": root, "entries": entries}).encode()
    numbered = {f"{name.removeprefix('array')}.npy": content for name, content in arrays.items()}
    path.write_bytes(sealed({"header.json": header(config), "state.json": state, **numbered}))
    return path


def npy(shape: tuple[int, ...], descr: str = "<f8", data: bytes = b"") -> bytes:
    file = io.BytesIO()
    np.lib.format.write_array_header_1_0(file, {"descr": descr, "fortran_order": False, "shape": shape})
    return file.getvalue() + data


class TestRoundTrip:
    def test_of_values(self, tmp_path):
        generator = np.random.default_rng(1)
        generator.random(5)
        generator.bit_generator.seed_seq.spawn(2)
        state = {
            "scalars": (np.float32(1.5), np.int64(3), np.bool_(True), np.str_("é"), None, 1j, slice(1), -0.0, 2**200),
            "floats": [float("inf"), -float("inf"), 0.1, 5e-324],
            "containers": [deque([1], maxlen=3), OrderedDict(a=1), {1, 2}, frozenset({3}), bytearray(b"x"), b"\xff"],
            "keys": {1: 2, ("x", None): 3, Phase.LIFT: 4, 2.5: 5, False: 6},
            "ours": (AttentionConfig(motion_gain=2.0), Phase.LIFT, CONFIG, Event(1, 2, 3)),
            "path": Path("weights.npz"),
            "range": range(3, 9, 2),
            "text": "\ud800 \x00 é",
        }
        save(tmp_path / "c", (state, generator), CONFIG)
        loaded, again = load(tmp_path / "c", CONFIG)
        assert loaded == state
        assert [type(value) for value in loaded["scalars"]] == [type(value) for value in state["scalars"]]
        assert str(loaded["scalars"][7]) == "-0.0"
        assert type(loaded["ours"][3]) is Event and loaded["ours"][2] is CONFIG
        assert loaded["containers"][0].maxlen == 3
        assert again.random() == generator.random()
        children = [rng.bit_generator.seed_seq.spawn(1)[0].generate_state(2).tolist() for rng in (again, generator)]
        assert children[0] == children[1]

    @pytest.mark.parametrize(
        "array",
        [
            np.arange(6.0).reshape(2, 3),
            np.zeros((0, 3), np.float32),
            np.array(3),
            np.asfortranarray(np.arange(6.0).reshape(2, 3)),
            np.arange(24).reshape(2, 3, 4)[:, ::2].T,
            np.array([np.nan, -np.inf, -0.0]),
            np.array(["é", "xyz"]),
            np.array([True, False]),
            np.zeros(3, np.dtype([("number", np.int32), ("sum", float)], align=True)),
            np.arange(3, dtype=">i2"),
            np.broadcast_to(np.arange(2.0), (4, 2)),
        ],
    )
    def test_of_arrays(self, tmp_path, array):
        save(tmp_path / "c", [array], CONFIG)
        (again,) = load(tmp_path / "c", CONFIG)
        np.testing.assert_array_equal(again, array)
        assert (again.dtype, again.dtype.isalignedstruct) == (array.dtype, array.dtype.isalignedstruct)
        assert again.flags.writeable
        if array.flags.c_contiguous or array.flags.f_contiguous:
            assert again.flags.f_contiguous == array.flags.f_contiguous

    def test_what_was_one_is_one_again(self, tmp_path):
        array, random = np.zeros(3), np.random.default_rng(0)
        shared: list[Any] = [array, random]
        shared.append(shared)
        save(tmp_path / "c", {"a": array, "b": (array, random), "c": shared}, CONFIG)
        loaded = load(tmp_path / "c", CONFIG)
        assert loaded["a"] is loaded["b"][0] is loaded["c"][0]
        assert loaded["b"][1] is loaded["c"][1]
        assert loaded["c"][2] is loaded["c"]

    def test_of_a_default(self, tmp_path):
        counts = defaultdict(int, x=3)
        save(tmp_path / "c", counts, CONFIG)
        loaded = load(tmp_path / "c", CONFIG)
        assert loaded == counts and loaded["y"] == 0

    @pytest.mark.parametrize("bits", [np.random.PCG64, np.random.PCG64DXSM, np.random.SFC64])
    def test_of_random_numbers(self, tmp_path, bits):
        generator = np.random.Generator(bits(7))
        generator.integers(5, size=3, dtype=np.uint32)  # leaves half of a draw
        save(tmp_path / "c", generator, CONFIG)
        np.testing.assert_array_equal(load(tmp_path / "c", CONFIG).random(9), generator.random(9))

    def test_the_same_state_gives_the_same_bytes(self, tmp_path):
        state = {"x": {"b", "a", "c"}, "y": np.arange(5), "z": np.random.default_rng(2)}
        save(tmp_path / "first", state, CONFIG)
        save(tmp_path / "second", load(tmp_path / "first", CONFIG), CONFIG)
        assert (tmp_path / "first").read_bytes() == (tmp_path / "second").read_bytes()

    def test_of_a_session_byte_for_byte(self, tmp_path):
        """Whatever lies in memory, and what becomes of it."""
        session = SessionRun(CONFIG)
        session.begin()
        for _ in range(400):
            session.step()
        save(tmp_path / "c", session, CONFIG)
        again = load(tmp_path / "c", CONFIG, kind=SessionRun)
        save(tmp_path / "again", again, CONFIG)
        assert (tmp_path / "c").read_bytes() == (tmp_path / "again").read_bytes()
        for each in (session, again):
            for _ in range(200):
                each.step()
        save(tmp_path / "c", session, CONFIG)
        save(tmp_path / "again", again, CONFIG)
        assert (tmp_path / "c").read_bytes() == (tmp_path / "again").read_bytes()


def test_parts_of_the_config_are_the_callers(tmp_path):
    """A file cannot say what an option is."""
    selector = AttentionSelector(CONFIG.robot.attention, 2, np.random.default_rng(0))
    save(tmp_path / "c", selector, CONFIG)
    assert b"selection_period" not in members_of(tmp_path / "c")["state.json"]
    other = replace(CONFIG, minutes=1.0)
    assert load(tmp_path / "c", other).config is other.robot.attention


def test_it_says_what_it_is(tmp_path):
    save(tmp_path / "c", [1], CONFIG)
    members = members_of(tmp_path / "c")
    given = json.loads(members["header.json"])
    assert given["format"] == FORMAT and given["config"] == fingerprint(CONFIG)
    assert given["versions"].keys() == {"python", "jointattn_mj", "numpy", "mujoco"}
    with zipfile.ZipFile(tmp_path / "c") as file:
        assert file.comment.startswith(b"jointattn checkpoint")


def test_fingerprint_knows_every_option():
    """Deep ones too. What is equal as a config is the same."""
    config = SessionConfig(minutes=1, perception="state")
    robot = config.robot
    others = [
        replace(config, seed=1),
        replace(config, start_from=Path("weights.npz")),
        replace(config, robot=replace(robot, attention=replace(robot.attention, motion_cues=False))),
        replace(config, world=replace(config.world, scene=replace(config.world.scene, caregiver="noa"))),
        replace(config, state=replace(config.state, face_noise_px=0.5600001)),
    ]
    prints = [fingerprint(each) for each in (config, *others)]
    assert len(set(prints)) == len(prints)
    assert fingerprint(SessionConfig(minutes=1.0, perception="state")) == prints[0]


class Own:
    """Of the module of somebody's own session class."""

    method_calls = 0

    def method(self):
        raise AssertionError("called")


@dataclass(frozen=True)
class Pair:
    left: Any
    right: Any


class Triple(NamedTuple):
    x: Any
    y: Any
    z: Any


class Colour(Enum):
    RED = 1
    CRIMSON = 1
    BLUE = 2


class Remade:
    """Says itself what is kept of it."""

    def __init__(self, size: int):
        self.size, self.table = size, np.arange(size)

    def __getstate__(self):
        return {"size": self.size}

    def __setstate__(self, state):
        self.__init__(state["size"])


class TestOwnClasses:
    def test_are_kept_where_the_caller_names_their_module(self, tmp_path):
        own = Own()
        own.value, own.me = 3, own
        state = [own, Pair(own, Colour.RED), Triple(1, Colour.CRIMSON, own), Remade(4)]
        save(tmp_path / "c", state, CONFIG, __name__)
        loaded, pair, triple, remade = load(tmp_path / "c", CONFIG, __name__)
        assert (loaded.value, loaded.me) == (3, loaded)
        assert type(pair) is Pair and pair.left is loaded and pair.right is Colour.RED
        assert type(triple) is Triple and triple.y is Colour.RED and triple.z is loaded
        assert remade.table.tolist() == [0, 1, 2, 3]
        with pytest.raises(CheckpointError, match="Own does not belong into a checkpoint"):
            load(tmp_path / "c", CONFIG)

    @pytest.mark.parametrize(
        ("thing", "words"),
        [
            (print, "builtin_function_or_method does not belong"),
            (Own, "type does not belong"),
            (lambda: 3, "function does not belong"),
            (object(), "object does not belong"),
            (io.BytesIO(), "BytesIO does not belong"),
            (np.array([{}]), "dtype object"),
            (np.rec.array([(1, 2.0)]), "recarray"),
            (np.random.RandomState(0), "RandomState does not belong"),
            (np.random.Generator(np.random.MT19937(0)), "use PCG64"),
            ({Pair(1, 2): 3}, "Pair cannot be a key"),
            (defaultdict(lambda: 3), "defaultdict"),
            ("\n".join, "does not belong"),
        ],
    )
    def test_what_is_no_data_is_not_written(self, tmp_path, thing, words):
        with pytest.raises(CheckpointError, match=words):
            save(tmp_path / "c", [thing], CONFIG, __name__)
        assert not list(tmp_path.iterdir())

    def test_what_hangs_on_itself_for_ever_is_not_written(self, tmp_path):
        chain: list[Any] = []
        for _ in range(100_000):
            chain = [chain]
        with pytest.raises(CheckpointError):
            save(tmp_path / "c", chain, CONFIG)


def test_a_config_of_another_version(tmp_path):
    """Its names may differ where nothing was changed; the version is what matters."""
    versions = {"jointattn_mj": "0.1.0"}
    head = json.dumps({"format": FORMAT, "config": "0" * 64, "versions": versions}).encode()
    (tmp_path / "c").write_bytes(sealed({"header.json": head, "state.json": b"{}"}))
    with pytest.raises(CheckpointError, match=r"written by version 0\.1\.0 of jointattn-mj.* cannot go on with it"):
        load(tmp_path / "c", CONFIG)


@pytest.mark.parametrize("text", ["config: {minutes: 1, seed: 3}", "config: 3", "{", "\0", ""])
def test_the_config_beside_it(tmp_path, text):
    save(tmp_path / "c", [1], replace(CONFIG, seed=3))
    (tmp_path / "config.yaml").write_text(text)
    words = r"config \(seed is 3 there and 0 here\);" if "seed" in text else "another config"
    with pytest.raises(CheckpointError, match=words):
        load(tmp_path / "c", replace(CONFIG, minutes=1))


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
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(CheckpointError, match="no regular file"):
        load(tmp_path / "pipe", CONFIG)


@pytest.fixture(scope="module")
def kept(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("kept") / "c"
    save(path, {"x": np.arange(50)}, CONFIG)
    return path


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_damage(kept, tmp_path, data):
    """Any byte that is changed, and any cut, is noticed."""
    whole = kept.read_bytes()
    location = data.draw(st.integers(0, len(whole) - 1))
    path = tmp_path / "c"
    if data.draw(st.booleans()):
        path.write_bytes(whole[:location])
    else:
        path.write_bytes(
            whole[:location] + bytes([whole[location] ^ data.draw(st.integers(1, 255))]) + whole[location + 1 :]
        )
    with pytest.raises(CheckpointError, match="damaged"):
        load(path, CONFIG)
    assert load(kept, CONFIG)["x"][-1] == 49


class Command:
    """What pickles into a call of os.system."""

    def __init__(self, command: str):
        self.command = command

    def __reduce__(self):
        return os.system, (self.command,)


class TestOtherFormats:
    def test_pickles_of_earlier_versions(self, tmp_path):
        """One line that says why, and what to do; nothing of it is unpickled."""
        marker = tmp_path / "marker"
        body = fingerprint(CONFIG).encode() + pickle.dumps(Command(f"touch {marker}"))
        digest = hashlib.sha256(body).hexdigest().encode()
        (tmp_path / "c").write_bytes(b"jointattn checkpoint 1\n" + digest + body)
        with pytest.raises(CheckpointError, match=r"earlier version.*not read any more; go on with that version"):
            load(tmp_path / "c", CONFIG)
        assert not marker.exists()

    def test_formats_to_come(self, tmp_path):
        (tmp_path / "c").write_bytes(sealed({"header.json": header()}, number=FORMAT + 1))
        with pytest.raises(CheckpointError, match=f"has format {FORMAT + 1}"):
            load(tmp_path / "c", CONFIG)

    def test_states_of_other_versions(self, tmp_path):
        """It says with what the file was written where that differs."""
        text = json.loads(header())
        text["versions"] = {"python": "3.99.1", "jointattn_mj": "0.0.1", "numpy": np.__version__, "mujoco": "9.9"}
        state = {
            "root": [0],
            "entries": [["object", "jointattn_mj.gaze_following.attention.AttentionConfig", "cues", True]],
        }
        content = {"header.json": json.dumps(text).encode(), "state.json": json.dumps(state).encode()}
        (tmp_path / "c").write_bytes(sealed(content))
        with pytest.raises(CheckpointError, match=r"other fields.*written with python 3\.99\.1, jointattn_mj 0\.0\.1"):
            load(tmp_path / "c", CONFIG)


class TestAttacks:
    """Files that are formally right and made up by somebody else. Nothing is called, made or believed."""

    @pytest.mark.parametrize(
        "name",
        [
            "jointattn_mj.video.stream.VideoEncoder",
            "jointattn_mj.footage.log.PerceptLog",
            "jointattn_mj.sweeps.backends.Dask",
            "jointattn_mj.video.reel.Reel",
            "jointattn_mj.io.codec.Decoder",
            "jointattn_mj.gaze_following.session.SessionConfig",
            "jointattn_mj.gaze_following.session.FrameTable",
            "jointattn_mj.gaze_following.session.SessionRun.step",
            "jointattn_mj.scene.world.Physics",
            "subprocess.Popen",
            "os.system",
            "builtins.bytearray",
            "builtins.type",
            "numpy.ndarray",
            "pathlib.PosixPath",
            "antigravity.fly",
            "SessionRun",
            "",
            ".",
            "tests.test_checkpoint.Own.method",
        ],
    )
    @pytest.mark.parametrize(("kind", "rest"), [("object", ("x", 1)), ("state", (1,)), ("named", ()), ("enum", ("X",))])
    def test_classes_that_are_not_listed(self, tmp_path, name, kind, rest):
        forge(tmp_path / "c", [[kind, name, *rest]])
        with pytest.raises(CheckpointError, match="does not belong into a checkpoint"):
            load(tmp_path / "c", CONFIG, __name__)
        assert "antigravity" not in sys.modules
        assert [path.name for path in tmp_path.iterdir()] == ["c"]

    @pytest.mark.parametrize(
        ("name", "attribute"),
        [
            ("gaze_following.session.SessionRun", "step"),
            ("gaze_following.session.SessionRun", "weights"),
            ("gaze_following.session.SessionRun", "__class__"),
            ("gaze_following.session.SessionRun", "__dict__"),
            ("gaze_following.session.SessionRun", "not a name"),
            ("perception.som.SOM", "width"),  # a property
            ("perception.som.SOM", "from_arrays"),
            ("footage.shots.Shots", "see"),
        ],
    )
    @pytest.mark.parametrize("value", [3, None, "x"])
    def test_methods_cannot_be_hidden(self, tmp_path, name, attribute, value):
        forge(tmp_path / "c", [["object", f"jointattn_mj.{name}", attribute, value]])
        with pytest.raises(CheckpointError, match="cannot be an attribute"):
            load(tmp_path / "c", CONFIG)

    def test_nor_by_what_a_class_restores_itself(self, tmp_path):
        world = [["state", "jointattn_mj.scene.world.World", [1]], ["dict", "image", 3]]
        with pytest.raises(CheckpointError, match="cannot be an attribute"):
            load(forge(tmp_path / "c", world), CONFIG)
        with pytest.raises(CheckpointError, match="not made of attributes"):
            load(forge(tmp_path / "c", [["object", "jointattn_mj.scene.world.World"]]), CONFIG)

    @pytest.mark.parametrize(
        ("entry", "words"),
        [
            (["object", "jointattn_mj.gaze_following.attention.AttentionConfig"], "other fields"),
            (
                ["object", "jointattn_mj.gaze_following.attention.AttentionConfig", "selection_period", 1, "more", 2],
                "other fields",
            ),
            (["named", "jointattn_mj.contingency.online.events.Event", 1, 2], "other fields"),
            (["named", "jointattn_mj.gaze_following.attention.AttentionConfig", 1, 2], "other fields"),
            (["enum", "jointattn_mj.scene.caregiver.Phase", "DANCE"], "DANCE"),
            (["enum", "jointattn_mj.scene.caregiver.Phase", "__init__"], "__init__"),
            (["enum", "jointattn_mj.gaze_following.session.SessionRun", "step"], "no enumeration"),
            (["object", "jointattn_mj.scene.caregiver.Phase", "x", 1], "not made of attributes"),
            (["list", [1]], "missing"),
            (["list", [-1]], "missing"),
            (["list", [10**30]], "missing"),
            (["tuple", [0]], "part of itself"),
            (["frozenset", [0]], "part of itself"),
            (["list", [1, 2]], "no value"),
            (["list", {"float": "1"}], "no value"),
            (["list", {"x": 1}], "no value"),
            (["dict", 1], ""),
            (["dict", [0], 1], "cannot be a key"),
            (["set", [0]], "part of itself"),
            (["config", "seed"], ""),
            (["config", "__class__"], ""),
            (["config", "robot", "..", "world"], ""),
            (["array", 0], ""),
            (["array", "../../etc/passwd"], ""),
            (["array", None], ""),
            (["scalar", "O", "00" * 8], "no dtype of numbers"),
            (["scalar", "V8", "00" * 8], "no dtype of numbers"),
            (["scalar", "<f8", "00"], ""),
            (["scalar", "i8,O", "00" * 16], "no dtype of numbers"),
            (["generator", "MT19937", None, None], "no generator"),
            (["generator", "RandomState", None, None], "no generator"),
            (["generator", "__class__", None, None], "no generator"),
            (["generator", "PCG64", None, None], "no generator"),
            (["seeds", 1, None, 10**10, 0], "pool"),
            (["seeds", "x", None, 4, 0], ""),
            (["default", "system"], ""),
            (["bytes", "no base64!"], ""),
            (["deque", -3], ""),
            (["range", 1, 2, 0], ""),
            (["list", -1e308], "beyond"),
            (["call", "os.system", "true"], "call"),
            (["__class__"], ""),
            ([["list"]], ""),
            ([], ""),
            ("list", ""),
            (3, ""),
            (None, ""),
        ],
    )
    def test_entries_that_nobody_wrote(self, tmp_path, entry, words):
        with pytest.raises(CheckpointError, match=words or None):
            load(forge(tmp_path / "c", [entry]), CONFIG)

    @pytest.mark.parametrize("number", [-1e308, 1e101])
    def test_numbers_that_no_run_has(self, tmp_path, number):
        array = npy((2,), data=np.array([np.nan, number]).tobytes())
        with pytest.raises(CheckpointError, match=r"beyond 1e\+100"):
            load(forge(tmp_path / "c", [["array", 0]], array0=array), CONFIG)

    @pytest.mark.parametrize(
        ("name", "value"), [("_end", 1e12), ("_end", np.nan), ("_progress", -3.0), ("_offset", 1.0), ("frame", 27)]
    )
    def test_gaze_shifts_of_no_head(self, tmp_path, name, value):
        shift = HeadShift(np.zeros(2), np.ones(2), 26)
        forged = np.array(getattr(shift, name))
        if forged.ndim:
            forged[1] = value
        setattr(shift, name, forged if forged.ndim else value)
        save(tmp_path / "c", shift, CONFIG)
        with pytest.raises(CheckpointError, match="gaze shift"):
            load(tmp_path / "c", CONFIG)

    @pytest.mark.parametrize("root", [3.5, [9], [], [[0]], {"float": "x"}, [True], [0.0]])
    def test_roots_that_are_none(self, tmp_path, root):
        with pytest.raises(CheckpointError):
            load(forge(tmp_path / "c", [["list"]], root), CONFIG, kind=SessionRun)

    @pytest.mark.parametrize("state", [b"", b"[", b"3", b"{}", b"\xff", b'{"root": NaN}', b"[" * 10**6, b"1" * 10**5])
    def test_text_that_nobody_wrote(self, tmp_path, state):
        (tmp_path / "c").write_bytes(sealed({"header.json": header(), "state.json": state}))
        with pytest.raises(CheckpointError):
            load(tmp_path / "c", CONFIG)

    def test_nests_without_end(self, tmp_path):
        nests = [["list", [number + 1]] for number in range(2 * 10**4)] + [["list"]]
        with pytest.raises(CheckpointError, match="Recursion"):
            load(forge(tmp_path / "c", nests), CONFIG)

    def test_keys_that_take_for_ever(self, tmp_path):
        """A tuple of twice a tuple, and so on: its hash takes 2^20 steps."""
        doubled = [["tuple", [number + 2], [number + 2]] for number in range(20)]
        with pytest.raises(CheckpointError, match="cannot be a key"):
            load(forge(tmp_path / "c", [["dict", [1], 0], *doubled, ["tuple"]]), CONFIG)

    @pytest.mark.parametrize("kind", ["tuple", "list"])
    def test_values_that_take_for_ever_to_write(self, tmp_path, kind):
        """As many as 2^60, and in an error message all of them."""
        doubled = [[kind, [number + 1], [number + 1]] for number in range(60)]
        with pytest.raises(CheckpointError, match="unfolds"):
            load(forge(tmp_path / "c", [*doubled, [kind]]), CONFIG, kind=(int, float))

    @pytest.mark.parametrize(
        "content",
        [
            npy((10**11,)),
            npy((10**11,), data=b"x" * 1000),
            npy((0, 10**30)),
            npy((-1,)),
            npy((2,), "|O", b"x" * 16),
            npy((2,), "<f8", b"x" * 15),
            npy((2,), "<f8", b"x" * 17),
            npy((10**12,), "|S0"),
            npy((10**12,), "|V0"),
            b"\x93NUMPY\x01\x00\xff\xff{'descr': ",
            b"\x93NUMPY\x03\x00\x10\x00\x00\x00",
            b"",
            b"no array",
            pickle.dumps(np.arange(3)),
        ],
    )
    def test_arrays_that_ask_for_more_than_they_have(self, tmp_path, content):
        with pytest.raises(CheckpointError):
            load(forge(tmp_path / "c", [["array", 0]], array0=content), CONFIG)

    @pytest.mark.parametrize("compression", [zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
    def test_bombs(self, tmp_path, compression):
        state = b'{"root": [0], "entries": [["list"' + b" " * 10**7 + b"]]}"
        (tmp_path / "c").write_bytes(sealed({"header.json": header(), "state.json": state}, compression))
        with pytest.raises(CheckpointError, match="compressed"):
            load(tmp_path / "c", CONFIG)

    def test_members_upon_each_other(self, tmp_path):
        """Many names for the same bytes."""
        buffer = io.BytesIO()
        with zipfile.ZipFile(buffer, "w") as file:
            fill(file, {"header.json": header(), "state.json": b"{}", "0.npy": npy((10**5,), data=b"x" * 800_000)}, 0)
            for number in range(1, 200):
                again = file.getinfo("0.npy")
                file.filelist.append(type(again)(f"{number}.npy"))
                vars_of = ("header_offset", "file_size", "compress_size", "CRC", "compress_type")
                for name in vars_of:
                    setattr(file.filelist[-1], name, getattr(again, name))
            file._didModify = True
            file.comment = b"jointattn checkpoint %d sha256=" % FORMAT + b"0" * 64
        content = buffer.getvalue()[:-64]
        (tmp_path / "c").write_bytes(content + hashlib.sha256(content).hexdigest().encode())
        with pytest.raises(CheckpointError, match="members have"):
            load(tmp_path / "c", CONFIG)

    @pytest.mark.parametrize("kind", [SessionRun, (float, SessionRun), int, (float, int, SessionRun)])
    def test_something_else_than_is_expected(self, tmp_path, kind):
        learner = LinearLearner(LearnerConfig(), 3)
        for state in (learner, (1.0, learner), [1.0, SessionRun], None):
            if state != [1.0, SessionRun]:
                save(tmp_path / "c", state, CONFIG)
                with pytest.raises(CheckpointError, match="it holds"):
                    load(tmp_path / "c", CONFIG, kind=kind)

    def test_in_a_command(self, tmp_path, capfd):
        """The encoder that started ffmpeg: one line, and nothing is written but the file itself."""
        from jointattn_mj.cli.main import main

        entry = ["object", "jointattn_mj.video.stream.VideoEncoder", "height", "16 -f data -i data:, -y victim.txt"]
        forge(tmp_path / "checkpoint.bin", [entry], config=TableDevelopmentConfig.of(preset="thesis"))
        with pytest.raises(SystemExit) as stop:
            main(["develop", "--out", str(tmp_path), "--resume"])
        assert stop.value.code == 2
        said = capfd.readouterr().err
        assert said.count("\n") == 1 and "Encoder does not belong into a checkpoint" in said
        learner = LinearLearner(LearnerConfig(), 3)
        save(tmp_path / "checkpoint.bin", learner, TableDevelopmentConfig.of(preset="thesis"))
        with pytest.raises(SystemExit):
            main(["develop", "--out", str(tmp_path), "--resume"])
        assert "it holds LinearLearner" in capfd.readouterr().err


def test_listed_classes_are_there_and_do_nothing_by_themselves():
    for name in PARTS:
        kind = class_named(name, "")
        assert f"{kind.__module__}.{kind.__qualname__}" == name
        assert not any(method in vars(base) for base in kind.__mro__ for method in ("__del__", "__call__", "__enter__"))


GROWING = replace(TableDevelopmentConfig.of(preset="fast"), steps=20_000)


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> dict[str, bytes]:
    """The checkpoint of a developing robot that has found something."""
    lived = GROWING.new_run()
    while not lived.agent.modules:
        lived.advance(500)
    path = tmp_path_factory.mktemp("life") / "c"
    save(path, lived, GROWING)
    return members_of(path) | {"header.json": header(GROWING)}


def somewhere(tree: Any, draw: Callable[[Any], Any]) -> tuple[Any, Any]:
    """A container in a JSON tree, and a place in it."""
    while True:
        location = draw(st.sampled_from(sorted(tree) if isinstance(tree, dict) else range(len(tree))))
        below = tree[location]
        if not isinstance(below, list | dict) or not below or draw(st.integers(0, 4)) == 0:
            return tree, location
        tree = below


ODD = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-3, 300),
    st.sampled_from([2**63, -(2**63), 10**40, 1e308, -1.5]),
    st.sampled_from(
        ["", "x", "step", "jointattn_mj.gaze_following.session.SessionRun", "list", "object", "<f8", "array"]
    ),
    st.integers(-2, 500).map(lambda number: [number]),
    st.sampled_from([{"float": "nan"}, {"float": "inf"}, [], {}, [[0]], ["list"], ["array", 0]]),
)


@settings(max_examples=120, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_whatever_is_changed_it_is_read_or_refused(run, tmp_path, data):
    """Changes that the digest is made to fit: a life that can go on comes out, or one named error."""
    members = dict(run)
    if data.draw(st.integers(0, 3)):
        state = json.loads(members["state.json"])
        for _ in range(data.draw(st.integers(1, 3))):
            container, location = somewhere(state, data.draw)
            container[location] = copy.deepcopy(data.draw(ODD))
        members["state.json"] = json.dumps(state).encode()
    else:
        name = data.draw(st.sampled_from(sorted(members.keys() - {"header.json"})))
        content = bytearray(members[name])
        location = data.draw(st.integers(0, min(len(content) - 1, 200)))
        content[location] ^= data.draw(st.integers(1, 255))
        members[name] = bytes(content)
    (tmp_path / "c").write_bytes(sealed(members))
    try:
        restored = load(tmp_path / "c", GROWING, kind=GROWING.kind)
    except CheckpointError as error:
        assert "\n" not in str(error)
    else:
        restored.advance(50)
