"""Trials on disk: what goes in comes out, whole or not at all, and nothing else is taken for a trial."""

import json
import os
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from toys.registry import REGISTRY

from jointattn_mj.errors import OutputError, TrialError
from jointattn_mj.sweeps.claim import Claim, Setting
from jointattn_mj.sweeps.run import Selection, plan
from jointattn_mj.sweeps.store import Keys, Store, text_of

COIN = REGISTRY["1.1"]


@dataclass(frozen=True)
class Config:
    shape: tuple[int, ...] = (1, 2)
    where: Path = Path("a/b")


@pytest.fixture
def store(tmp_path) -> Store:
    store = Store(tmp_path)
    store.prepare(COIN.id)
    return store


def tasks(claim: Claim = COIN, runs: int = 2):
    return list(plan([claim], Selection(runs=runs)))


def fill(store: Store, claim: Claim = COIN, runs: int = 2) -> None:
    for task in tasks(claim, runs):
        store.write(task, text_of({"seed": task.seed, "of": task.name}), versions={"a": "1"}, wall_seconds=0.1)


def test_one_text_for_one_value():
    given = {"b": np.float64(0.1), "a": np.array([1, 2]), "c": (True, None, np.nan), 3: np.bool_(False)}
    assert text_of(given) == '{"3":false,"a":[1,2],"b":0.1,"c":[true,null,null]}'
    assert text_of(Config()) == '{"shape":[1,2],"where":"a/b"}'


@pytest.mark.parametrize("value", [np.inf, {"a": [1, -np.inf]}, {"a": object()}, {1, 2}])
def test_what_is_no_plain_data(value):
    with pytest.raises(TrialError, match="expected"):
        text_of(value)


def test_what_goes_in_comes_out(store):
    fill(store, runs=3)
    stored = store.read(COIN)
    assert list(stored.trials) == ["fair", "loaded"]
    assert [(trial.setting, trial.seed, trial.result) for trial in stored.trials["loaded"]] == [
        ("loaded", seed, {"seed": seed, "of": "loaded"}) for seed in range(3)
    ]
    assert (stored.others, stored.damaged) == (0, ())
    assert [versions["a"] for versions in stored.versions] == ["1"]
    assert store.known(COIN.id) == {task.key for task in tasks(runs=3)}


def test_a_file_says_all(store):
    fill(store, runs=1)
    document = json.loads(store.path(tasks()[0]).read_text())
    assert document["config"] == {"heads": 0.5, "throws": 50}
    assert (document["claim"], document["setting"], document["seed"]) == ("1.1", "fair", 0)
    assert document["wall_seconds"] == 0.1


def test_a_key_hangs_on_everything():
    def key(claim=COIN, seed=0, name="fair"):
        return Keys(claim).key(name, seed)

    keys = {
        key(),
        key(seed=1),
        key(name="loaded"),
        key(replace(COIN, id="1.3")),
        key(replace(COIN, version=2)),
    }
    assert len(keys) == 5
    assert key() == key(replace(COIN, title="another", settings=dict(reversed(COIN.settings.items()))))
    assert len(key()) == 32


def test_equal_settings_share_their_trials(store):
    claim = replace(COIN, settings={"a": Setting({"x": 1}, 1), "b": Setting({"x": 1}, 1)})
    first, second = tasks(claim, runs=1)
    store.write(first, "{}")
    assert store.has(second)
    assert {name: len(trials) for name, trials in store.read(claim).trials.items()} == {"a": 1, "b": 1}


def test_trials_of_before(store):
    """Those of an older version, or of a setting that is no more, are counted and left alone."""
    fill(store)
    raised = store.read(replace(COIN, version=2))
    assert (raised.trials, raised.others) == ({}, 4)
    fewer = store.read(replace(COIN, settings={"fair": COIN.settings["fair"]}))
    assert (list(fewer.trials), fewer.others) == (["fair"], 2)


@pytest.mark.parametrize("content", [b"", b'{\n"claim": "1.1",\n"seed', b"\0" * 200, b"[]\n}\n", b"{\n}\n"])
def test_damaged_files(store, content):
    fill(store)
    path = store.path(tasks()[0])
    path.write_bytes(content)
    stored = store.read(COIN)
    assert stored.damaged == (path,)
    assert len(stored.trials["fair"]) == 1


def test_half_a_file_is_computed_again(store):
    """As after a loss of power."""
    fill(store)
    path = store.path(tasks()[0])
    path.write_bytes(path.read_bytes()[:-4])
    assert not store.has(tasks()[0])
    assert len(store.known(COIN.id)) == 3


def test_a_file_under_another_name(store):
    fill(store)
    path = store.path(tasks()[0])
    path.rename(path.with_stem("0" * 32))
    assert len(store.read(COIN).damaged) == 1


def test_failures_go_when_the_trial_succeeds(store):
    task = tasks()[0]
    store.write_failure(task, "ValueError: no", "line 1\nline 2", "run it alone")
    (failure,) = store.failures(COIN.id)
    assert failure["traceback"] == ["line 1", "line 2"]
    store.write(task, "{}")
    assert store.failures(COIN.id) == []


def test_full_disk(store, monkeypatch):
    def full(*arguments):
        raise OSError(28, "No space left on device")

    fill(store, runs=1)
    before = store.path(tasks()[0]).read_bytes()
    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(OutputError, match="No space left on device; free space"):
        store.write(tasks()[0], '{"other": 1}')
    assert store.path(tasks()[0]).read_bytes() == before
    assert len(list(store.path(tasks()[0]).parent.iterdir())) == 2


def test_no_folder_to_be_had(tmp_path):
    (tmp_path / "trials").write_text("a file")
    with pytest.raises(OutputError, match="cannot make the folder"):
        Store(tmp_path).prepare("1.1")
    assert Store(tmp_path / "nowhere").known("1.1") == frozenset()


def test_folders_of_version_0_1(tmp_path):
    """Their trials lie in ``cells``; they are read, and a run in them goes on there."""
    former = Store(tmp_path)
    (tmp_path / "cells").mkdir()
    former.prepare(COIN.id)
    fill(former, runs=1)
    assert {path.name for path in tmp_path.iterdir()} == {"cells", "failed"}
    assert len(Store(tmp_path).known(COIN.id)) == 2
    assert {name: len(trials) for name, trials in Store(tmp_path).read(COIN).trials.items()} == {"fair": 1, "loaded": 1}


def test_what_killed_processes_left(store):
    folder = store.path(tasks()[0]).parent
    old, fresh = folder / ".abc.12.json", folder / ".def.13.json"
    old.write_text("half")
    fresh.write_text("half")
    os.utime(old, (time.time() - 7200,) * 2)
    store.prepare(COIN.id)
    assert (old.exists(), fresh.exists()) == (False, True)
    assert store.known(COIN.id) == frozenset()
    assert store.read(COIN).damaged == ()


def test_runs_of_one_folder_are_told_apart(tmp_path):
    with Store(tmp_path).berth() as first, Store(tmp_path).berth() as second:
        assert (first, second) == (0, 1)
    with Store(tmp_path).berth() as again:
        assert again == 0
    with Store(tmp_path / "not there").berth() as nowhere:
        assert nowhere == 0


def test_a_field_that_came_later_changes_no_key():
    """At the value that it had without being there; any other is another trial."""
    from jointattn_mj.gaze_following.gate import GazeConfig
    from jointattn_mj.gaze_following.learners import LearnerConfig
    from jointattn_mj.sweeps.store import ADDED, config_text

    def text(**options) -> str:
        return config_text({"learner": LearnerConfig(**options), "gaze": GazeConfig()})

    assert not [name for names in ADDED.values() for name in names if f'"{name}"' in text()]
    assert '"pairs":"in_view"' in text(code="cross_situational", pairs="in_view")
    for group, config in (("learner", LearnerConfig()), ("gaze", GazeConfig())):
        assert all(getattr(config, name) == value for name, value in ADDED[group].items())
