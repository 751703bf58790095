"""Free memory: the least of what machine and container leave."""

import pytest

from jointattn_mj.recording import memory
from jointattn_mj.recording.memory import available_bytes


def container(folder, most, used, cached):
    (folder / "memory.max").write_text(f"{most}\n")
    (folder / "memory.current").write_text(f"{used}\n")
    (folder / "memory.stat").write_text(f"anon 5\ninactive_file {cached}\nactive_file 7\n")


@pytest.fixture
def cgroup(tmp_path, monkeypatch):
    monkeypatch.setattr(memory, "CGROUP", tmp_path)
    return tmp_path


def test_container_has_less_than_the_machine(cgroup):
    """What it keeps of files gives way to whoever needs the place."""
    container(cgroup, most=1_000_000, used=700_000, cached=200_000)
    assert available_bytes() == 500_000


def test_container_that_is_full(cgroup):
    container(cgroup, most=1000, used=2000, cached=0)
    assert available_bytes() == 0


@pytest.mark.parametrize("bound", ["max", None])
def test_no_bound(cgroup, bound):
    if bound is not None:
        container(cgroup, bound, used=10**15, cached=0)
    machine = available_bytes()
    assert machine is None or machine > 10**7


def test_system_that_does_not_say(cgroup, monkeypatch):
    monkeypatch.setattr(memory, "MEMINFO", cgroup / "nothing")
    assert available_bytes() is None
