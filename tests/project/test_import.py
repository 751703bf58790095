"""What importing the package brings with it: little, and nothing of OpenGL; what is optional asks for itself."""

import os
import subprocess
import sys

import pytest

from jointattn_mj.cli.main import main

pytestmark = pytest.mark.integration

HEAVY = ("numpy", "mujoco", "dm_control", "OpenGL", "torch", "cv2", "numba", "scipy", "matplotlib", "pyarrow", "tyro")
EXTRAS = ("gymnasium", "stable_baselines3", "rerun", "dask", "distributed", "mkdocs", "IPython")
IMPORT = """
import sys
import jointattn_mj
print(*sorted(name for name in {modules} if name in sys.modules))
print(*sorted({{line.split("/")[-1].strip() for line in open("/proc/self/maps") if "GL" in line or "OSMesa" in line}}))
"""


def python(code: str, **environment: str) -> subprocess.CompletedProcess:
    """Run in a fresh interpreter in which no backend was chosen."""
    kept = {name: value for name, value in os.environ.items() if name not in ("MUJOCO_GL", "PYOPENGL_PLATFORM")}
    return subprocess.run(
        [sys.executable, "-c", code], env=kept | environment, capture_output=True, text=True, timeout=120
    )


@pytest.mark.skipif(sys.platform != "linux", reason="reads the process's memory map")
def test_importing_the_package_is_light():
    done = python(IMPORT.format(modules=HEAVY + EXTRAS))
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "\n\n"


def test_little_comes_before_the_command_line_minds_stop_signals():
    """What is imported until then leaves a traceback when it is interrupted."""
    slow = {"typing", "tempfile", "pathlib", "ctypes", "random", "shutil", "importlib.util", "argparse", "re"}
    code = "import sys, threading; known = {*sys.modules}; import jointattn_mj.cli.main; print(*{*sys.modules} - known)"
    new = set(python(code).stdout.split())
    assert "jointattn_mj.io.terminal" in new and not new & slow


COMMAND_LINE = """
import sys
from importlib import import_module
from jointattn_mj.cli.commands import COMMANDS
from jointattn_mj.cli.main import main
{code}
print(*sorted(name for name in {modules} if name in sys.modules))
"""
DRAWN_OR_TESTED = ("matplotlib", "scipy.stats", "scipy.cluster", "scipy.optimize", "scipy.fft", "mediapy", "jinja2")
"""What only figures, tests and films need."""


def test_the_list_of_commands_imports_nothing_heavy():
    done = python(COMMAND_LINE.format(code="main(['--help'])", modules=(*HEAVY, "yaml", "tqdm")))
    assert done.returncode == 0, done.stderr
    assert "session" in done.stdout
    assert done.stdout.splitlines()[-1] == ""


def test_no_command_imports_what_draws_or_tests_before_it_is_asked_for_that():
    code = "for name in COMMANDS: import_module(f'jointattn_mj.cli.{name}')"
    done = python(COMMAND_LINE.format(code=code + "\nprint('numpy' in sys.modules)", modules=DRAWN_OR_TESTED))
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == ["True", ""]


@pytest.mark.parametrize("called, own", [("main()", True), ("main(sys.argv[1:])", False)])
def test_the_collector_leaves_alone_what_a_command_imports_in_a_process_of_its_own(called, own):
    code = f"import gc, sys; from jointattn_mj.cli.main import main; sys.argv[1:] = ['--version']; {called}"
    done = python(code + "; print(gc.isenabled(), gc.get_freeze_count() > 0)")
    assert done.stdout.splitlines()[-1] == f"True {own}"


@pytest.mark.parametrize("word", ["--version", "--verzion", "session --minutes many"])
def test_garbage_is_collected_after_a_command_that_failed_too(word):
    code = f"import gc, sys; from jointattn_mj.cli.main import main; sys.argv[1:] = {word.split()}"
    done = python(f"{code}\ntry:\n    main()\nexcept SystemExit:\n    pass\nprint(gc.isenabled())")
    assert done.stdout.splitlines()[-1] == "True"


@pytest.mark.parametrize("reader", ["mujoco", "dm_control.mujoco"])
def test_a_backend_is_chosen_before_mujoco_reads_it(reader):
    code = f"import os, jointattn_mj; before = 'MUJOCO_GL' in os.environ\nimport {reader}\n"
    done = python(code + "print(before, os.environ['MUJOCO_GL'])")
    assert done.returncode == 0, done.stderr
    before, backend = done.stdout.split()
    assert before == "False"
    assert backend in ("egl", "osmesa", "disable")


def test_a_backend_that_was_asked_for_stays():
    done = python("import jointattn_mj, mujoco, os; print(os.environ['MUJOCO_GL'])", MUJOCO_GL="off")
    assert (done.stdout.strip(), done.returncode) == ("off", 0), done.stderr


def test_no_extra_is_imported_unless_it_is_used(tmp_path):
    session = f"session --perception state --minutes 0.02 --robot.familiarise.minutes 0.02 --out {tmp_path / 'session'}"
    run = f"develop --steps 100 --out {tmp_path / 'life'}"
    code = f"""
import sys
from jointattn_mj.cli.main import main
main({session.split()!r})
main({run.split()!r})
print("extras:", *(name for name in {EXTRAS} if name in sys.modules))
"""
    done = python(code)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "extras:"


NEED_EXTRAS = {
    "python_calamine": ("excel", "measure book.xlsx --source a --target b"),
    "rerun": ("rerun", "session --perception state --minutes 0.02 --out out --rerun log.rrd"),
    "distributed": ("cluster", "experiment run 4.4 --backend dask --address tcp://127.0.0.1:9 --out out"),
}


@pytest.mark.parametrize("package", NEED_EXTRAS)
def test_an_extra_that_is_missing_asks_for_itself_by_name(package, tmp_path, monkeypatch, capsys):
    extra, command = NEED_EXTRAS[package]
    for name in [name for name in sys.modules if name.split(".")[0] == package]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, package, None)  # as if it were not installed
    monkeypatch.chdir(tmp_path)
    (tmp_path / "book.xlsx").write_bytes(b"PK\x03\x04")  # as every workbook begins
    with pytest.raises(SystemExit):
        main(command.split())
    said = capsys.readouterr().err
    assert f"pip install 'jointattn-mj[{extra}]'" in said
    assert not (tmp_path / "out" / "config.yaml").exists()
