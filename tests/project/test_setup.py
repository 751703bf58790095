"""What `make demo` and `make test` begin with: checks before downloads, repair, progress, one line for what fails."""

import ast
import importlib.util
import json
import shutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

ROOT = Path(__file__).parents[2]
SCRIPT = ROOT / "tools" / "setup.py"
pytestmark = [
    pytest.mark.integration,
    pytest.mark.skipif(sys.platform == "win32", reason="locks and environments as on POSIX"),
]
OPENGL_LINE = "apt-get install --no-install-recommends libegl1 libopengl0 libgl1-mesa-dri"


@pytest.fixture
def setup(tmp_path, monkeypatch) -> ModuleType:
    """The script in a checkout of its own, on a machine that has everything and installs nothing."""
    (tmp_path / "tools").mkdir()
    shutil.copy(SCRIPT, tmp_path / "tools")
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    spec = importlib.util.spec_from_file_location("setup_script", tmp_path / "tools" / "setup.py")
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "setup_script", module)  # dataclasses look it up
    spec.loader.exec_module(module)
    monkeypatch.setattr(module, "EVERY_S", 0.05)
    monkeypatch.setattr(module, "missing_system_packages", lambda: [])
    monkeypatch.setattr(module.shutil, "disk_usage", lambda location: SimpleNamespace(free=10**11))
    return module


def make_environment(setup: ModuleType, pip: str = "exit 0", kind: str | None = None) -> None:
    """An environment whose pip is a shell script; made by the script itself where a ``kind`` is given."""
    (setup.VENV / "bin").mkdir(parents=True)
    python = setup.VENV / "bin" / "python"
    python.write_text(f"#!/bin/sh\n{pip}\n")
    python.chmod(0o755)
    if kind is not None:
        setup.READY.write_text(json.dumps(setup.wanted_from(kind)))


def never(*arguments: object, **named: object) -> None:
    pytest.fail(f"was called with {arguments}")


def test_an_old_python_is_told_in_one_line():
    code = "import runpy, sys; sys.version_info = (3, 9, 2); runpy.run_path(sys.argv[1], run_name='__main__')"
    done = subprocess.run([sys.executable, "-c", code, str(SCRIPT)], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert "3.11 or later is needed" in done.stderr and "is 3.9;" in done.stderr and done.stderr.count("\n") == 1
    ast.parse(SCRIPT.read_text(), feature_version=(3, 6))  # an old one comes as far as that line


def test_a_full_disk_is_found_before_anything_is_downloaded(setup, monkeypatch, capsys):
    monkeypatch.setattr(setup.shutil, "disk_usage", lambda location: SimpleNamespace(free=10**9))
    monkeypatch.setattr(setup, "watch", never)
    with pytest.raises(SystemExit) as stop:
        setup.main(["demo"])
    said = capsys.readouterr().out
    assert stop.value.code == 1
    assert "397 MB to download" in said and "1.0 GB are free" in said
    assert not setup.VENV.exists()


@pytest.mark.parametrize("kind", ["demo", "test"])
def test_without_sudo_the_administrators_line_is_said_and_the_demo_goes_on(setup, monkeypatch, capsys, kind):
    make_environment(setup, "touch called")
    monkeypatch.chdir(setup.ROOT)
    monkeypatch.setattr(setup, "missing_system_packages", lambda: list(setup.OPENGL))
    monkeypatch.setattr(setup.os, "geteuid", lambda: 1000)
    monkeypatch.setattr(setup, "sudo_lets", lambda: False)
    if kind == "test":
        with pytest.raises(SystemExit) as stop:
            setup.main([kind])
        assert stop.value.code == 1
    else:
        setup.main([kind])
    assert f"for the administrator: apt-get update && {OPENGL_LINE}\n" in capsys.readouterr().out
    assert (setup.ROOT / "called").exists() == (kind == "demo")


def test_without_pip_for_environments_nothing_is_downloaded(setup, monkeypatch, capsys):
    monkeypatch.setattr(setup, "missing_system_packages", lambda: ["python3.11-venv", *setup.OPENGL])
    monkeypatch.setattr(setup, "apt", lambda packages: False)
    monkeypatch.setattr(setup, "watch", never)
    with pytest.raises(SystemExit):
        setup.main(["demo"])
    assert "install --no-install-recommends python3.11-venv libegl1" in capsys.readouterr().out


def test_opengl_that_is_installed_and_does_not_work_is_not_asked_for_again(setup, monkeypatch, capsys):
    make_environment(setup)
    monkeypatch.setattr(setup, "missing_system_packages", lambda: list(setup.OPENGL))
    monkeypatch.setattr(setup, "apt", lambda packages: True)
    setup.main(["demo"])
    said = capsys.readouterr().out
    assert "see README, Troubles" in said and "administrator" not in said


@pytest.mark.parametrize(("there", "asked"), [("test", "demo"), ("test", "test"), ("demo", "demo")])
def test_what_is_there_is_not_installed_again(setup, monkeypatch, capsys, there, asked):
    make_environment(setup, kind=there)
    for part in setup.KINDS[there]:
        package = setup.VENV / "lib" / "python3" / "site-packages" / part.package
        package.mkdir(parents=True)
        (package / "__init__.py").touch()
    monkeypatch.setattr(setup, "watch", never)
    setup.main([asked])
    assert capsys.readouterr().out == ""


def test_tests_after_the_demo_bring_the_rest_alone(setup, monkeypatch, capsys):
    make_environment(setup, "echo $* >> asked", kind="demo")
    (setup.VENV / "lib/python3/site-packages/mujoco").mkdir(parents=True)
    (setup.VENV / "lib/python3/site-packages/mujoco/__init__.py").touch()
    monkeypatch.chdir(setup.ROOT)
    setup.main(["test"])
    said = capsys.readouterr().out
    assert "demo" not in said and "PyTorch" in said and "tools for tests" in said
    asked = (setup.ROOT / "asked").read_text().splitlines()
    assert asked[0].endswith(f"--editable {setup.ROOT}[dev]")
    assert len(asked) == 1 + (sys.version_info >= (3, 13))
    assert setup.made_from()["kind"] == "test"


def test_another_project_file_is_installed_again(setup, capsys):
    make_environment(setup, kind="test")
    with (setup.ROOT / "pyproject.toml").open("a") as file:
        file.write("# another line\n")
    setup.main(["demo"])
    assert "ready after" in capsys.readouterr().out
    assert setup.made_from() == setup.wanted_from("test")


def test_progress_is_told_and_pip_is_not(setup, capsys):
    slowly = 'echo "WARNING: of packaging"; head -c 3000000 /dev/zero > $TMPDIR/wheel; sleep 1; echo {}; sleep 1'
    make_environment(setup, slowly.format(f'"{setup.CHANGES}: numpy"'))
    setup.main(["demo"])
    said = capsys.readouterr().out
    assert "downloaded 3 of about 397 MB" in said
    assert "installed 0 of about 1350 MB" in said
    assert "WARNING" not in said
    assert not setup.LOG.exists() and not setup.TEMPORARY.exists()


def test_pip_that_fails_is_told_in_one_line_and_what_was_there_stays(setup, capsys):
    make_environment(setup, 'echo "Collecting torch"; echo "ERROR: no route to the index"; exit 1', kind="demo")
    with pytest.raises(SystemExit) as stop:
        setup.main(["test"])
    assert stop.value.code == 1
    assert "pip could not: ERROR: no route to the index (all it said:" in capsys.readouterr().out.splitlines()[-1]
    setup.repair()
    assert setup.made_from() == setup.wanted_from("demo")


@pytest.mark.parametrize("why", ["interrupted", "folder", "no Python"])
def test_what_cannot_be_gone_on_with_is_made_anew(setup, capsys, why):
    make_environment(setup, kind="demo")
    if why == "interrupted":
        setup.LOG.write_text(f"Collecting numpy\n{setup.CHANGES}: numpy\n")
    elif why == "folder":
        setup.READY.write_text(json.dumps(setup.wanted_from("demo") | {"folder": "/somewhere"}))
    else:
        (setup.VENV / "bin" / "python").unlink()
    setup.repair()
    assert why in capsys.readouterr().out
    assert not setup.VENV.exists()


def test_somebody_elses_environment_is_kept(setup):
    make_environment(setup)
    setup.repair()
    assert setup.VENV.exists()


@pytest.mark.skipif(not shutil.which("make"), reason="no make")
def test_make_without_a_python_says_so():
    command = ["make", "--no-print-directory", "demo", "PYTHON=python3.no"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert done.returncode == 2
    assert done.stdout == "setup: there is no python3.no; Python 3.11 or later is needed\n"
