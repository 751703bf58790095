"""Everything but networks and Stable-Baselines3 works where torch is not installed, as after `make demo`."""

import os
import subprocess
import sys

import numpy as np
import pytest
from clips import encode

pytestmark = pytest.mark.integration

ROOT = os.path.dirname(os.path.dirname(__file__))
WITHOUT = """
import sys
from importlib import metadata

version = metadata.version
def without(name):
    if name == "torch":
        raise metadata.PackageNotFoundError(name)
    return version(name)

class Without:
    def find_spec(self, name, path, target=None):
        if name.split(".")[0] in ("torch", "triton"):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

metadata.version = without
sys.meta_path.insert(0, Without())
"""
"""Makes a process one in which torch is not installed."""

IMPORTS = """
import pkgutil
from importlib import import_module
import experiments, jointattn_mj
from jointattn_mj.errors import ExtraError

for package in (jointattn_mj, experiments):
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        try:
            import_module(module.name)
        except ExtraError as error:
            print(module.name, str(error).partition("(")[0], sep=": ")
        except ImportError as error:  # another extra's package, under the module that asks for it
            assert error.name.split(".")[0] in ("rerun", "viser", "mjviser", "gymnasium", "dask"), (module.name, error)
"""
RUN = """
from jointattn_mj.cli.main import main
main(sys.argv[1:])
"""


def python(code: str, *arguments: object) -> subprocess.CompletedProcess:
    command = [sys.executable, "-c", WITHOUT + code, *map(str, arguments)]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=600)


def test_what_needs_torch_asks_for_it_and_nothing_else_does():
    done = python(IMPORTS)
    assert done.returncode == 0, done.stderr
    asked = {line.split(": ")[0] for line in done.stdout.splitlines() if "torch" in line.split(": ", 1)[1]}
    assert "jointattn_mj.gaze_following.network_learner" in asked
    assert asked <= {"jointattn_mj.gaze_following.network_learner", "experiments.follow.training"}


def test_commands(tmp_path):
    video = encode(tmp_path / "grey.mkv", np.full((30, 48, 64, 3), 128, np.uint8))
    brief = ("--perception", "state", "--minutes", "0.02", "--robot.familiarise.minutes", "0.02")
    turns = tmp_path / "develop" / "steps.parquet"
    variables = ("--source", "caregiver's face", "--condition", "shift gaze", "--target", "object", "--surrogates", 20)
    for command in (
        ("session", *brief, "--out", tmp_path / "session"),
        ("develop", "--steps", "500", "--out", tmp_path / "develop"),
        ("measure", turns, *variables),
        ("play", "follow", "--agent", "oracle", "--episodes", "1", "--out", tmp_path / "play"),
        ("perceive", video, "--objects", "red", "--out", tmp_path / "perceive"),
    ):
        done = python(RUN, *command)
        assert done.returncode == 0, (command, done.stderr)
    assert "torch" not in (tmp_path / "session" / "config.yaml").read_text()


def test_a_network_as_learner_asks_for_torch_by_name(tmp_path):
    done = python(RUN, "session", "--perception", "state", "--robot.learner.code", "network", "--out", tmp_path / "out")
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1 and "pip install 'jointattn-mj[torch]'" in done.stderr
