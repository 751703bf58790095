"""What a run computes, and what goes wrong with one trial and not with the others. No process is started."""

import json
from concurrent.futures import CancelledError, Future
from dataclasses import replace

import pytest
from toys.registry import REGISTRY

from jointattn_mj.errors import ConfigError, OutputError, SweepError
from jointattn_mj.options import RenamedWarning
from jointattn_mj.sweeps.claim import Setting
from jointattn_mj.sweeps.run import Selection, SweepWatcher, Tally, command, plan, run
from jointattn_mj.sweeps.store import Store

COIN = REGISTRY["1.1"]


class Death(Exception):
    pass


class Here:
    """Computes at once, in this process; ``dies`` says how often each seed kills its worker."""

    deaths = (Death,)
    most_deaths = 3

    def __init__(self, slots: int = 2, together: bool = True, dies: dict[int, int] | None = None):
        self._slots, self.all_die_together, self.dies = slots, together, dies or {}
        self.seeds, self.alive, self.closed, self.restarts = [], True, False, 0
        self._last: list[Future] = []

    def slots(self) -> int:
        return self._slots

    def submit(self, function, packed, seed):
        self.seeds.append(seed)
        future = Future()
        if self.dies.get(seed, 0) > 0:
            self.dies[seed] -= 1
            self.alive = not self.all_die_together
            future.set_exception(Death())
        elif not self.alive:
            future.set_exception(Death())
        else:
            future.set_result(function(packed, seed))
        return future

    def restart(self):
        self.alive = True
        self.restarts += 1

    def close(self):
        self.closed = True


class Gone(Here):
    """Its workers are gone for good while the third trial is computed."""

    def submit(self, function, packed, seed):
        if len(self.seeds) < 2:
            return super().submit(function, packed, seed)
        future = Future()
        future.set_exception(SweepError("no card"))
        return future


def go(folder, backend=None, runs=4, setting="fair", claims=(COIN,), **more) -> Tally:
    return run(claims, Selection(setting, runs), folder, backend or Here(), **more)


def stored(folder, claim=COIN) -> dict[str, list[int]]:
    return {name: [trial.seed for trial in trials] for name, trials in Store(folder).read(claim).trials.items()}


def test_settings_take_turns():
    tasks = plan([COIN], Selection(runs=2))
    assert [(task.name, task.seed) for task in tasks] == [("fair", 0), ("loaded", 0), ("fair", 1), ("loaded", 1)]


def test_own_numbers_of_runs_and_seeds():
    broken = REGISTRY["1.2"]
    assert [task.seed for task in plan([broken], Selection())] == [5, 6]
    assert [task.seed for task in plan([broken], Selection(runs=1, seed=9))] == [9]
    uneven = replace(COIN, settings={"a": Setting({}, 0), "b": Setting({"x": 1}, 2)})
    assert [(task.name, task.seed) for task in plan([uneven], Selection())] == [("b", 0), ("b", 1)]


def test_a_setting_by_its_id_or_how_it_begins():
    claim = replace(COIN, settings={name: Setting({"of": name}, 1) for name in ("a", "a/b", "a/c", "d")})
    assert Selection("a").names(claim) == ["a"]
    assert Selection("a/").names(claim) == ["a/b", "a/c"]
    with pytest.raises(ConfigError, match="no setting is called 'x' or begins so; there are a, a/b, a/c, d"):
        list(plan([claim], Selection("x")))


def test_settings_by_their_names_of_the_last_version():
    claim = replace(COIN, settings={name: Setting({"of": name}, 1) for name in ("state/cues", "pixels/cues")})
    with pytest.warns(RenamedWarning, match=r"truth/cues is now called state/cues"):
        assert Selection("truth/cues").names(claim) == ["state/cues"]


@pytest.mark.parametrize("bad", [{"runs": 0}, {"seed": -1}])
def test_bad_selections(bad):
    with pytest.raises(ConfigError, match=next(iter(bad))):
        Selection(**bad)


def test_only_what_is_missing(tmp_path):
    backend = Here()
    tally = go(tmp_path, backend, runs=3)
    assert (tally.todo, tally.stored, tally.done, backend.closed) == (3, 0, 3, True)
    more = Here()
    tally = go(tmp_path, more, runs=5)
    assert (tally.todo, tally.stored, tally.done, more.seeds) == (2, 3, 2, [3, 4])
    assert stored(tmp_path) == {"fair": [0, 1, 2, 3, 4]}


def test_results_do_not_hang_on_how_they_were_computed(tmp_path):
    go(tmp_path / "a", Here(slots=1))
    go(tmp_path / "b", Here(slots=7, dies={2: 1}))
    a, b = (Store(tmp_path / name).read(COIN).trials for name in "ab")
    assert a == b


@pytest.mark.parametrize("kind", ["error", "exit"])
def test_an_error_ends_one_trial(tmp_path, monkeypatch, kind):
    monkeypatch.setenv("TOY_TROUBLE", f"{kind}:1")
    tally = go(tmp_path, registry="toys.registry")
    assert (tally.done, stored(tmp_path)) == (3, {"fair": [0, 2, 3]})
    ((task, error, alone),) = tally.failed
    assert (task.seed, error.split(":")[0]) == (1, {"error": "ValueError", "exit": "SystemExit"}[kind])
    expected = f"run 1.1 --setting fair --seed 1 --runs 1 --registry toys.registry --out {tmp_path}"
    assert alone == f"jointattn experiment {expected}"
    (failure,) = Store(tmp_path).failures("1.1")
    assert "misbehave(seed)" in " ".join(failure["traceback"])
    monkeypatch.delenv("TOY_TROUBLE")
    assert go(tmp_path).done == 1
    assert Store(tmp_path).failures("1.1") == []


@pytest.mark.parametrize("together", [True, False])
def test_a_death_costs_no_trial(tmp_path, together):
    tally = go(tmp_path, Here(slots=3, together=together, dies={1: 1}), runs=6)
    assert (tally.deaths, tally.failed, tally.done) == (1, [], 6)


@pytest.mark.parametrize("together", [True, False])
def test_a_trial_that_always_kills_is_found(tmp_path, together):
    """It is tried again last, and in the end alone, so that nobody is blamed for another's deed."""
    backend = Here(slots=3, together=together, dies={1: 99})
    tally = go(tmp_path, backend, runs=6)
    assert stored(tmp_path) == {"fair": [0, 2, 3, 4, 5]}
    ((task, error, _),) = tally.failed
    assert (task.seed, backend.seeds.count(1)) == (1, 3)
    assert "died" in error
    assert backend.seeds.count(5) == 1


@pytest.mark.parametrize("dies", [1, 99])
def test_trials_of_a_crowd_are_tried_again_in_halves(tmp_path, dies):
    """One by one they would take as long as a crowd is there to save."""
    backend = Here(slots=64, dies={37: dies})
    alone: list[int] = []

    class Alone(SweepWatcher):
        def tick(self, tally, slots):
            alone.append(tally.running)

    tally = go(tmp_path, backend, runs=64, watcher=Alone())
    assert (tally.done, len(tally.failed)) == ((64, 0) if dies == 1 else (63, 1))
    assert len(alone) < 20 and alone.count(1) < 6
    assert min(dies + 1, 3) <= backend.seeds.count(37) < 10


def test_a_dead_pool_refuses_work(tmp_path):
    class Refuses(Here):
        def submit(self, function, packed, seed):
            if not self.restarts:
                raise Death
            return super().submit(function, packed, seed)

    assert go(tmp_path, Refuses()).done == 4


def test_what_another_run_has_stored_meanwhile(tmp_path):
    class Other(SweepWatcher):
        def begin(self, tally, slots):
            go(tmp_path, runs=3)

    backend = Here()
    tally = go(tmp_path, backend, watcher=Other())
    assert (tally.todo, tally.stored, tally.done, backend.seeds) == (1, 3, 1, [3])


def test_nobody_computes_any_more(tmp_path):
    class Gone(Here):
        def submit(self, function, packed, seed):
            future = Future()
            future.set_exception(CancelledError())
            return future

    with pytest.raises(SweepError, match="start scheduler and workers again"):
        go(tmp_path, Gone())


def test_a_full_disk_ends_the_run(tmp_path, monkeypatch):
    def full(self, *arguments, **beside):
        raise OutputError("full")

    backend = Here()
    monkeypatch.setattr(Store, "write", full)
    with pytest.raises(OutputError):
        go(tmp_path, backend)
    assert backend.closed


def test_infinite_results_are_refused(tmp_path):
    claim = replace(COIN, trial=endless)
    ((_, error, _),) = go(tmp_path, claims=[claim], runs=1).failed
    assert error.startswith("TrialError: expected finite numbers")


def endless(config, seed):
    return {"never": float("inf")}


def test_time_left_goes_by_setting():
    tally = Tally(seconds={("a", "slow"): (2, 20.0), ("a", "quick"): (10, 1.0)})
    tally.left.update({("a", "slow"): 3, ("a", "quick"): 10, ("a", "new"): 12})
    assert tally.work_left_s() == pytest.approx(30 + 1 + 12 * 21 / 12)
    assert Tally().work_left_s() is None


def test_wall_time_stands_beside_the_result(tmp_path):
    go(tmp_path, runs=1)
    (path,) = (tmp_path / "trials" / "1.1").iterdir()
    assert json.loads(path.read_text())["wall_seconds"] >= 0


def test_commands_can_be_pasted(tmp_path):
    assert command(["a b"], tmp_path / "c d", runs=None).endswith(f"run 'a b' --out '{tmp_path / 'c d'}'")


def test_trials_do_not_fail_with_workers_that_are_gone_for_good(tmp_path):
    backend = Gone()
    with pytest.raises(SweepError, match="no card"):
        go(tmp_path, backend)
    assert backend.closed
    assert stored(tmp_path) == {"fair": [0, 1]}
    assert not Store(tmp_path).failures(COIN.id)
    assert go(tmp_path).done == 2
