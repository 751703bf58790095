"""Weights from anywhere: read whole, finite and of a size that the file has, or refused by name."""

import io
import zipfile

import numpy as np
import pytest

from jointattn_mj.errors import CheckpointError, ConfigError
from jointattn_mj.gaze_following.agent import FamiliariseConfig, RobotConfig
from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.io.weights import read_weights, write_weights
from jointattn_mj.perception.som import SOM, SOMConfig

CONFIG = SessionConfig(minutes=1, perception="state", robot=RobotConfig(familiarise=FamiliariseConfig(minutes=0.02)))


@pytest.fixture(scope="module")
def learned():
    session = SessionRun(CONFIG)
    session.begin()
    session.close()
    return session.weights()


@pytest.fixture(scope="module")
def session():
    session = SessionRun(CONFIG)
    yield session
    session.close()


def test_round_trip(tmp_path, learned):
    write_weights(tmp_path / "w.npz", learned)
    again = read_weights(tmp_path / "w.npz")
    assert again.keys() == learned.keys()
    for name, array in learned.items():
        np.testing.assert_array_equal(again[name], array)
        assert again[name].dtype == array.dtype


@pytest.mark.parametrize("name", ["som_weights", "learner", "iterations"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_numbers_that_are_not_finite(tmp_path, learned, name, value):
    spoilt = np.array(learned[name], float)
    spoilt.flat[0] = value
    write_weights(tmp_path / "w.npz", learned | {name: spoilt})
    with pytest.raises(CheckpointError, match=rf"not finite in {name}"):
        read_weights(tmp_path / "w.npz")


def test_numbers_whose_square_overflows(tmp_path, learned):
    write_weights(tmp_path / "w.npz", learned | {"som_weights": np.full((81, 2), 1e29)})
    with pytest.raises(CheckpointError, match=r"no real number up to 1e\+15 in som_weights"):
        read_weights(tmp_path / "w.npz")


def bomb(shape: tuple[int, ...], data: bytes, size: int | None = None) -> bytes:
    """A small file that asks for much memory."""
    member, file = io.BytesIO(), io.BytesIO()
    np.lib.format.write_array_header_1_0(member, {"descr": "<f8", "fortran_order": False, "shape": shape})
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("learner.npy", member.getvalue() + data)
        if size is not None:
            archive.infolist()[0].file_size = size
    return file.getvalue()


@pytest.mark.parametrize(
    "content",
    [
        bomb((10**11,), b""),
        bomb((10**11,), b"x" * 8000),
        bomb((10**5,), b"\0" * 800_000, size=10**12),
        bomb((0, 10**30), b""),
        b"PK",
        b"",
    ],
)
def test_files_that_ask_for_more_than_they_have(tmp_path, content):
    (tmp_path / "w.npz").write_bytes(content)
    with pytest.raises(CheckpointError, match=r"is not a weights\.npz"):
        read_weights(tmp_path / "w.npz")


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("iterations", np.array(np.inf)),
        ("iterations", np.array(-1)),
        ("iterations", np.array(1.5)),
        ("iterations", np.array([3])),
        ("iterations", np.array(2**63, np.uint64)),
        ("som_seen", np.array(2**62)),
        ("iterations", np.array("3")),
        ("som_seen", np.array(np.nan)),
        ("som_seen", np.array(-5)),
        ("som_weights", np.full((81, 2), np.nan)),
        ("som_weights", np.full((81, 2), 1e300)),
        ("learner", np.full((82, 21, 11), np.inf)),
        ("learner", np.zeros((82, 21, 11), complex)),
        ("learner", np.zeros((82, 21, 11), "U3")),
        ("learner", np.zeros((82, 21, 12))),
    ],
)
def test_a_robot_takes_nothing_that_does_not_fit(session, learned, name, value):
    """And stays as it was."""
    before = session.weights()
    with pytest.raises(ConfigError, match="do not fit"):
        session.robot.load(learned | {name: value})
    after = session.weights()
    for each, array in before.items():
        np.testing.assert_array_equal(after[each], array)


def test_a_map_says_what_is_wrong_with_its_weights():
    with pytest.raises(ConfigError, match="finite"):
        SOM.from_arrays({"weights": np.full((81, 2), np.inf), "seen": np.array(1)}, SOMConfig())
