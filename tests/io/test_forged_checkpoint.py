"""Checkpoints of a session that are whole by their digest, and changed inside: one named error, or a session."""

import json
import random
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from jointattn_mj.development.config import DevelopmentOptions
from jointattn_mj.development.run import run_development
from jointattn_mj.development.table.config import TableDevelopmentConfig
from jointattn_mj.errors import CheckpointError, ConfigError, JointAttnError
from jointattn_mj.gaze_following.run import SessionOptions, run_session
from jointattn_mj.gaze_following.session import SessionRun
from jointattn_mj.io.checkpoint import gone_on_with, save
from jointattn_mj.io.fitting import check_fits
from jointattn_mj.perception.mean_face import MeanFace, MeanFaceConfig
from tests.io.test_checkpoint import CONFIG, members_of, sealed

PLACES = ("visible", "x_px", "iterations")


@pytest.fixture(scope="module")
def members(tmp_path_factory) -> dict[str, bytes]:
    """Of a checkpoint after two seconds."""
    path = tmp_path_factory.mktemp("session") / "c"
    session = SessionRun(CONFIG)
    session.begin()
    for _ in range(60):
        session.step()
    save(path, (1.0, session), CONFIG, SessionRun.__module__)
    return members_of(path)


def resumed(folder: Path, members: dict[str, bytes], state: Any) -> None:
    folder.mkdir()
    (folder / "checkpoint.bin").write_bytes(sealed(members | {"state.json": json.dumps(state).encode()}))
    run_session(CONFIG, SessionOptions(folder, resume=True))


def entries_with(state: Any, word: str) -> Iterator[tuple[list[Any], int]]:
    """Entries in which a word stands, and where."""
    for entry in state["entries"]:
        for place, value in enumerate(entry):
            if value == word:
                yield entry, place


@pytest.mark.parametrize("word", PLACES)
def test_names_of_a_table_are_those_of_a_new_session(members, tmp_path, word):
    state = json.loads(members["state.json"])
    entry, place = next(entries_with(state, word))
    entry[place] = "other"
    with pytest.raises(CheckpointError, match=r"must be|has no|has other|cannot be"):
        resumed(tmp_path / "out", members, state)


@pytest.mark.parametrize(
    ("kind", "attribute"), [("SOM", "_norms"), ("PopulationLearner", "_weights"), ("FrameTable", "above")]
)
def test_what_is_missing_is_named(members, tmp_path, kind, attribute):
    state = json.loads(members["state.json"])
    entry = next(part for part in state["entries"] if part[0] == "object" and part[1].endswith(f".{kind}"))
    place = entry.index(attribute)
    del entry[place : place + 2]
    with pytest.raises(CheckpointError, match=f"has no {attribute}"):
        resumed(tmp_path / "out", members, state)


@pytest.mark.parametrize(
    ("word", "value", "said"),
    [
        ("total", 90, "1800"),
        ("total", 9000, "1800"),
        ("frame", 59, "the table has 60"),
        ("frame", -1, "the table has 60"),
    ],
)
def test_length_is_that_of_the_config(members, tmp_path, word, value, said):
    state = json.loads(members["state.json"])
    entry, place = next(entries_with(state, word))
    entry[place + 1] = value
    with pytest.raises(CheckpointError, match=f"{value}.*{said}"):
        resumed(tmp_path / "out", members, state)


def test_columns_of_a_table_are_in_their_order(members, tmp_path):
    """Numbers would stand under other names."""
    state = json.loads(members["state.json"])
    table = next(part for part in state["entries"] if part[0] == "object" and part[1].endswith(".FrameTable"))
    (number,) = table[table.index("index") + 1]
    columns = state["entries"][number]
    columns[2], columns[4] = columns[4], columns[2]
    with pytest.raises(CheckpointError, match="the table of frames has other columns"):
        resumed(tmp_path / "out", members, state)


DEVELOPMENT = TableDevelopmentConfig.of(preset="fast", steps=300)


@pytest.fixture(scope="module")
def developed(tmp_path_factory) -> dict[str, bytes]:
    """Members of the checkpoint of a development."""
    out = tmp_path_factory.mktemp("development") / "out"
    run_development(DEVELOPMENT, DevelopmentOptions(out))
    return members_of(out / "checkpoint.bin")


def refuses(path: Path, members: dict[str, bytes], state: Any, said: str) -> None:
    path.write_bytes(sealed(members | {"state.json": json.dumps(state).encode()}))
    with pytest.raises(CheckpointError, match=said):
        run_development(DEVELOPMENT, DevelopmentOptions(path.parent, resume=True))


def test_numbers_of_a_rule_are_those_of_the_config(developed, tmp_path):
    """When an event counts as found, for one."""
    changed = 0
    for number, entry in enumerate(json.loads(developed["state.json"])["entries"]):
        for place in [k for k, value in enumerate(entry) if entry[0] == "named" and type(value) is float]:
            state = json.loads(developed["state.json"])
            state["entries"][number][place] = {"float": "-inf"}
            refuses(tmp_path / "checkpoint.bin", developed, state, f"must be {entry[place]}|rules of the table")
            changed += 1
    assert changed >= 10


@pytest.mark.parametrize("word", ["n_steps", "sample_every", "every"])
def test_length_of_a_development_is_that_of_its_config(developed, tmp_path, word):
    """Steps in all, and steps from one note of contingency to the next."""
    state = json.loads(developed["state.json"])
    entry, place = next((entry, place) for entry, place in entries_with(state, word) if type(entry[place + 1]) is int)
    entry[place + 1] += 1
    refuses(tmp_path / "checkpoint.bin", developed, state, "under this config|its log says")


def test_weights_of_another_robot(members, tmp_path):
    """One array in the place of another."""
    state = json.loads(members["state.json"])
    learner, som = (
        next(part for part in state["entries"] if part[0] == "object" and part[1].endswith(f".{kind}"))
        for kind in ("PopulationLearner", "SOM")
    )
    learner[learner.index("_weights") + 1] = som[som.index("weights") + 1]
    with pytest.raises(CheckpointError, match="_weights must be"):
        resumed(tmp_path / "out", members, state)


def test_a_mean_face_is_there_if_the_config_says_so(tmp_path):
    config = replace(
        CONFIG, perception="pixels", robot=replace(CONFIG.robot, mean_face=MeanFaceConfig(subtracted=True))
    )
    session = SessionRun(config)
    for wrong in (None, MeanFace(1)):
        session.robot.mean_face = wrong
        save(tmp_path / "checkpoint.bin", (1.0, session), config, SessionRun.__module__)
        with pytest.raises(CheckpointError, match=r"mean_face.* must be"):
            run_session(config, SessionOptions(tmp_path, resume=True))
    session.close()


def test_what_no_check_has_foreseen_is_laid_to_the_checkpoint(tmp_path):
    with pytest.raises(CheckpointError, match=r"checkpoint\.bin does not fit.*IndexError: 7"):  # noqa: SIM117
        with gone_on_with(tmp_path / "checkpoint.bin", True):
            raise IndexError(7)
    with pytest.raises(IndexError), gone_on_with(tmp_path, False):
        raise IndexError(7)
    with pytest.raises(ConfigError), gone_on_with(tmp_path, True):
        raise ConfigError("no")


def test_errors_of_the_caller_are_the_callers(tmp_path):
    def progress() -> None:
        raise IndexError(7)

    with pytest.raises(IndexError), gone_on_with(tmp_path, True, progress):
        progress()
    with pytest.raises(CheckpointError), gone_on_with(tmp_path, True, json.loads):
        progress()


@pytest.mark.slow
def test_changed_anywhere(members, tmp_path):
    """Random changes: a session that ends, or one line that is an error of this package."""
    for number in range(150):
        draw = random.Random(number)
        state = json.loads(members["state.json"])
        entry = draw.choice([part for part in state["entries"] if len(part) > 1])
        entry[draw.randrange(len(entry))] = draw.choice([None, True, -1, 0, 300, 2**63, 1e308, -1.5, "", "x", [0], [9]])
        out = tmp_path / str(number)
        try:
            resumed(out, members, state)
        except JointAttnError as error:
            assert "\n" not in str(error)


class TestFits:
    @pytest.mark.parametrize(
        ("restored", "new"), [(3, 5), (3, 2.5), (None, None), ([1, 2], [0]), ([1], []), ({"a": 2}, {"a": 1}), (4, None)]
    )
    def test_what_may_differ(self, restored, new):
        check_fits(restored, new, "it")

    @pytest.mark.parametrize(
        ("restored", "new"),
        [(2.5, 3), (True, 3), (1, True), (None, 3), ("x", 3), (["x"], [0]), ({"b": 1}, {"a": 1}), ((1, 2), (1, 3))],
    )
    def test_what_may_not(self, restored, new):
        with pytest.raises(ValueError, match="it"):
            check_fits(restored, new, "it")
