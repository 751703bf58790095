"""Real worker processes: loky's, and dask's behind a scheduler that somebody else started."""

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from toys.registry import REGISTRY

from jointattn_mj.errors import ConfigError, SweepError
from jointattn_mj.parallel.backend_choice import new_backend
from jointattn_mj.sweeps.backends import Dask, Loky
from jointattn_mj.sweeps.run import Selection, run
from jointattn_mj.sweeps.store import Store

pytestmark = pytest.mark.integration

COIN = REGISTRY["1.1"]


def heads(folder):
    return [trial.result for trial in Store(folder).read(COIN).trials["fair"]]


def test_options_that_do_not_go_together():
    with pytest.raises(ConfigError, match="needs `address`, such as"):
        new_backend("dask", 0, None)
    with pytest.raises(ConfigError, match="is for `backend='dask'`"):
        new_backend("loky", 0, "tcp://127.0.0.1:1")
    with pytest.raises(ConfigError, match="1 or more"):
        new_backend("loky", -1, None)
    assert Loky().slots() >= 1


def test_no_scheduler():
    with pytest.raises(SweepError, match=r"no dask scheduler answers at tcp://127\.0\.0\.1:9 .*; start one"):
        Dask("tcp://127.0.0.1:9", patience_s=0.3)


def test_loky_survives_a_killed_worker(tmp_path, monkeypatch):
    """kill -9 in the middle of a trial; and nobody in a worker takes more than one core."""
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    monkeypatch.setenv("TOY_TROUBLE", f"kill_once:3:{tmp_path / 'marker'}")
    tally = run([COIN], Selection("fair"), tmp_path, Loky(2))
    assert (tally.deaths, tally.failed, tally.done) == (1, [], 8)
    assert {result["threads"] for result in heads(tmp_path)} == {"1"}


HEAVY = {"mujoco", "torch", "cv2", "matplotlib", "dm_control"}


def test_a_worker_imports_what_its_trial_needs():
    backend = Loky(1)
    try:
        backend.submit(sorted, [])  # starts it
        code = f"import sys; sys.path.append({str(Path(__file__).parents[1])!r}); import toys.coin.sweep"
        assert backend.submit(exec, code).result() is None
        assert backend.submit(eval, f"__import__('sys').modules.keys() & {set(HEAVY)!r}").result() == set()
    finally:
        backend.close()


def test_a_worker_ends_with_the_main_process(tmp_path):
    program = (
        "import os, sys, time\n"
        "from jointattn_mj.sweeps.backends import Loky\n"
        "backend = Loky(1)\n"
        "print(backend.submit(os.getpid).result(), flush=True)\n"
        "time.sleep(60)\n"
    )
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True) as main:
        worker = int(main.stdout.readline())
        os.kill(worker, 0)
        main.kill()
    until = time.monotonic() + 10
    while alive(worker):
        assert time.monotonic() < until
        time.sleep(0.05)


def alive(process: int) -> bool:
    """Whether it runs; one that has ended and that nobody has asked for does not."""
    try:
        return "\nState:\tZ" not in Path(f"/proc/{process}/status").read_text()
    except FileNotFoundError:
        return False


@pytest.fixture
def scheduler(tmp_path):
    """Address of a scheduler with two workers on loopback, each in a process of its own."""
    pytest.importorskip("distributed")
    quiet = os.environ | {"PYTHONPATH": str(Path(__file__).parents[1]), "PYTHONWARNINGS": "ignore"}
    options = {"env": quiet, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    where = tmp_path / "scheduler.json"
    dask = [sys.executable, "-m", "dask"]
    processes = [
        subprocess.Popen(
            [*dask, "scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", where],
            **options,
        )
    ]
    for name in ("one", "two"):
        command = [*dask, "worker", "--scheduler-file", where, "--nthreads", "1", "--no-nanny", "--no-dashboard"]
        folder = ["--local-directory", tmp_path / name, "--name", name]
        processes.append(subprocess.Popen([*command, *folder], **options))
    from distributed import Client

    try:
        until = time.monotonic() + 60
        while not where.exists():
            assert time.monotonic() < until
            time.sleep(0.05)
        with Client(scheduler_file=str(where), set_as_default=False) as client:
            client.wait_for_workers(2, timeout=60)
            address = client.scheduler.address
        yield address, processes
    finally:
        for process in processes:
            process.kill()
            process.wait()


def test_dask_computes_the_same_and_survives_a_killed_worker(tmp_path, monkeypatch, scheduler):
    address, processes = scheduler

    class Killer(Dask):
        trials = 0

        def submit(self, function, *arguments):
            self.trials += 1
            if self.trials == 3:
                processes[2].kill()
            return super().submit(function, *arguments)

    backend = Killer(address)
    assert backend.slots() == 2
    tally = run([COIN], Selection("fair"), tmp_path / "there", backend)
    assert (tally.failed, tally.done) == ([], 8)
    run([COIN], Selection("fair"), tmp_path / "here", Loky(1))
    there, here = heads(tmp_path / "there"), heads(tmp_path / "here")
    assert [result["heads"] for result in there] == [result["heads"] for result in here]


@pytest.fixture
def slow(monkeypatch):
    """Coins take their time; for workers that are started after it."""
    monkeypatch.setenv("TOY_TROUBLE", "sleep:.2")


def test_a_killed_scheduler_is_one_line(tmp_path, slow, scheduler):
    """No stack trace before it, and what was computed is there."""
    address, processes = scheduler
    out = tmp_path / "out"
    command = f"experiment run 1.1 --registry toys.registry --runs 200 --backend dask --address {address} --out {out}"
    with subprocess.Popen(
        [sys.executable, "-m", "jointattn_mj.cli.main", *command.split()],
        env=os.environ | {"PYTHONPATH": os.pathsep.join([str(Path(__file__).parents[1]), *sys.path])},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        while not (out / "trials" / "1.1").is_dir() or len(list((out / "trials" / "1.1").glob("[!.]*"))) < 3:
            assert process.poll() is None, process.stderr.read()
            time.sleep(0.05)
        processes[0].kill()
        said, err = process.communicate(timeout=120)
    assert (process.returncode, said) == (1, "")
    first, state, last = err.splitlines()
    assert first == "400 trials to compute, 0 stored already"
    assert "/400 trials" in state
    assert last.startswith("jointattn: the workers are gone (")
    assert last.endswith("and the same command goes on")
    assert len(Store(out).read(COIN).trials["fair"]) >= 1


def test_trials_that_wait_when_all_is_stopped_say_nothing(monkeypatch):
    """loky's own thread would: it looks up what it has thrown away."""
    heard = []
    monkeypatch.setattr(threading, "excepthook", heard.append)
    for _ in range(3):
        backend = Loky(1)
        backend.submit(time.sleep, 0).result()
        for _ in range(8):
            backend.submit(time.sleep, 5)
        backend.close()
    assert not heard
