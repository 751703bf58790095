"""Compiled code is stored apart for each state of the sources."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import jointattn_mj
from jointattn_mj.io import compiled


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Two files, one of which is inlined into the other, and a third with nothing compiled."""
    monkeypatch.setenv(compiled.VARIABLE, "")
    monkeypatch.setitem(sys.modules, "numba", None)
    monkeypatch.delitem(sys.modules, "numba")
    folder = tmp_path / "package"
    (folder / "inner").mkdir(parents=True)
    (folder / "inner" / "one.py").write_text("from numba import njit\n")
    (folder / "two.py").write_text("from numba import njit  # and more\n")
    (folder / "words.py").write_text("'''No compiled code.'''\n")
    return folder


def chosen(package: Path) -> Path:
    compiled.choose_folder(package)
    return Path(os.environ[compiled.VARIABLE])


def test_another_folder_for_other_sources(package):
    first = chosen(package)
    assert first.parent == package / "__pycache__"
    assert first.is_dir()
    assert chosen(package) == first
    (package / "words.py").write_text("'''Other words.'''\n")
    assert chosen(package) == first
    (package / "inner" / "one.py").write_text("from numba import njit  # changed\n")
    assert chosen(package) != first


def test_a_folder_that_is_named(package, tmp_path, monkeypatch):
    monkeypatch.setenv(compiled.VARIABLE, str(tmp_path / "mine"))
    assert chosen(package).parent == tmp_path / "mine"
    assert chosen(package).parent == tmp_path / "mine"  # as in a process that this one starts


def test_where_nothing_can_be_written(package):
    (package / "__pycache__").write_text("in the way")
    compiled.choose_folder(package)
    assert os.environ[compiled.VARIABLE] == ""


def test_old_folders_are_forgotten(package):
    old, recent, other = (package / "__pycache__" / name for name in ("jointattn-old", "jointattn-recent", "other"))
    for folder in (old, recent, other):
        folder.mkdir(parents=True)
    for folder in (old, other):
        os.utime(folder, (0, 0))
    chosen(package)
    assert not old.exists()
    assert recent.exists()
    assert other.exists()


def test_what_was_inlined_from_a_changed_file_is_compiled_again(tmp_path):
    """Without the folder, numba would go on with the old mixture."""
    package = tmp_path / "toy"
    package.mkdir()
    shutil.copy(compiled.__file__, package / "compiled.py")
    (package / "__init__.py").write_text("from toy import compiled\ncompiled.choose_folder()\n")
    inner = "from numba import njit\n\n@njit(cache=True)\ndef inner():\n    return {}\n"
    (package / "outer.py").write_text(
        "from numba import njit\nfrom toy.inner import inner\n\n@njit(cache=True)\ndef outer():\n    return inner()\n"
    )
    said = []
    for value in (1, 2):
        (package / "inner.py").write_text(inner.format(value))
        environment = {**os.environ, compiled.VARIABLE: "", "PYTHONPATH": str(tmp_path)}
        code = "from toy.outer import outer; print(outer())"
        said.append(
            subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True).stdout
        )
    assert said == ["1\n", "2\n"]


def test_this_package_has_one():
    folder = Path(os.environ[compiled.VARIABLE])
    assert folder.name == f"jointattn-{compiled.state(Path(jointattn_mj.__file__).parent)}"
