"""Images through either software backend, and one clear message where there is none."""

import os
import subprocess
import sys

import pytest

from jointattn_mj.scene import gl

pytestmark = pytest.mark.integration

LOOK = """
import numpy as np
from jointattn_mj.scene.world import World, WorldConfig
world = World.build(WorldConfig(), np.random.SeedSequence(0))
image = world.image()
print(image.shape, image.std() > 5)
world.close()
"""


def look(**environment: str) -> subprocess.CompletedProcess:
    kept = {name: value for name, value in os.environ.items() if name not in ("MUJOCO_GL", "PYOPENGL_PLATFORM")}
    return subprocess.run(
        [sys.executable, "-c", LOOK], env=kept | environment, capture_output=True, text=True, timeout=120
    )


@pytest.mark.parametrize("backend", [name for name in gl.LIBRARIES if gl.available(name)])
def test_every_backend_that_is_here_shows_the_scene_and_leaves_cleanly(backend):
    done = look(MUJOCO_GL=backend)
    assert done.stdout.strip() == "(240, 320, 3) True"
    assert (done.returncode, done.stderr) == (0, "")


def test_a_backend_is_chosen_for_the_user():
    assert look().stdout.strip() == "(240, 320, 3) True"


@pytest.mark.parametrize("backend", [name for name in gl.LIBRARIES if gl.available(name)])
def test_capitals_and_blanks_are_no_matter(backend):
    assert look(MUJOCO_GL=f" {backend.upper()} ").stdout.strip() == "(240, 320, 3) True"


@pytest.mark.parametrize("choice", ["glfw", "GLFW", "glx", "on"])
def test_without_a_display_windows_are_one_named_error(choice):
    done = look(MUJOCO_GL=choice, DISPLAY="")
    assert done.returncode == 1
    assert "GLError" in done.stderr and "no display" in done.stderr
    assert "Exception ignored" not in done.stderr and "Warning" not in done.stderr


@pytest.mark.parametrize(
    ("choice", "words"), [("disable", "turns rendering off"), ("nonsense", "no way to render"), ("Off", "turns")]
)
def test_no_backend_is_one_named_error(choice, words):
    """Where another one works, nothing need be installed."""
    done = look(MUJOCO_GL=choice)
    assert done.returncode == 1
    assert "GLError" in done.stderr and words in done.stderr
    assert "works here: leave MUJOCO_GL out" in done.stderr and "apt-get" not in done.stderr


@pytest.mark.parametrize(("device", "choice"), [("", ""), ("99", "egl"), ("-1", "")])
def test_no_such_device(device, choice):
    done = look(MUJOCO_EGL_DEVICE_ID=device, MUJOCO_GL=choice)
    assert "GLError" in done.stderr and f"MUJOCO_EGL_DEVICE_ID={device!r} is no device" in done.stderr


def test_nothing_found_disables_rendering(monkeypatch):
    monkeypatch.setattr(gl, "_loads", lambda name: False)
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    gl.choose_backend()
    assert gl.rendering_disabled()
    assert "libegl1" in gl.why_not()
