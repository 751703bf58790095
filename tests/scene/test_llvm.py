"""OpenGL and triton in one process, whichever is first: both bring an LLVM, and one must not be taken for the other."""

import os
import subprocess
import sys
from importlib.machinery import EXTENSION_SUFFIXES, ExtensionFileLoader
from importlib.util import find_spec

import pytest

from jointattn_mj.scene import gl, llvm

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="Mesa and triton meet on Linux only")

CONTEXT = "import mujoco; context = mujoco.GLContext(8, 8); context.make_current()"
TORCH = """
import torch
weight = torch.nn.Parameter(torch.ones(2))
descent = torch.optim.Adam([weight])
weight.sum().backward()
descent.step()
"""
DM_CONTROL = """
import jointattn_mj
env = jointattn_mj.load("joint_attention", "follow", task_kwargs={"random": 0})
env.reset()
env.physics.render(height=24, width=32)
"""
GYMNASIUM = """
import gymnasium
env = gymnasium.make("jointattn_mj:Follow-v0", render_mode="rgb_array")
env.reset(seed=0)
env.render()
"""
OTHER_SUITE = """
from dm_control import suite
suite.load("cartpole", "swingup").physics.render(height=24, width=32)
"""
PACKAGE = "import jointattn_mj"
ORDERS = {
    "package, OpenGL, torch": (PACKAGE, CONTEXT, TORCH),
    "package, OpenGL, triton": (PACKAGE, CONTEXT, "import triton"),
    "package, torch, OpenGL": (PACKAGE, TORCH, CONTEXT),
    "torch, package, OpenGL": (TORCH, PACKAGE, CONTEXT),
    "torch imported, package, OpenGL, torch used": ("import torch", PACKAGE, CONTEXT, TORCH),
    "OpenGL, package, torch": (CONTEXT, PACKAGE, TORCH),
    "OpenGL, torch imported, package, torch used": (CONTEXT, "import torch", PACKAGE, TORCH),
    "mujoco, package, torch imported, OpenGL, torch used": ("import mujoco", PACKAGE, "import torch", CONTEXT, TORCH),
    "an environment of dm_control, torch": (DM_CONTROL, TORCH),
    "an environment of Gymnasium, torch": (GYMNASIUM, TORCH),
    "another suite of dm_control, torch": (PACKAGE, OTHER_SUITE, TORCH),
}


@pytest.mark.skipif(find_spec("triton") is None, reason="triton comes with PyTorch's builds for CUDA only")
@pytest.mark.skipif(not gl.available("egl"), reason="needs EGL")
@pytest.mark.parametrize("order", ORDERS)
def test_opengl_and_triton_meet_in_any_order(order):
    code = "\n".join((*ORDERS[order], "import triton", "print(triton.__name__)"))
    environment = {name: value for name, value in os.environ.items() if name != "PYOPENGL_PLATFORM"}
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=environment | {"MUJOCO_GL": "egl"},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert (done.returncode, done.stdout) == (0, "triton\n"), done.stderr


@pytest.fixture
def compiled(tmp_path):
    """What stands for triton's compiled module: the finder looks at the name alone."""
    (tmp_path / f"libtriton{EXTENSION_SUFFIXES[0]}").touch()
    return lambda: llvm._TritonFinder().find_spec("triton._C.libtriton", [str(tmp_path)])


def test_triton_is_bound_to_itself_beside_another_llvm(compiled, monkeypatch):
    flags = []
    monkeypatch.setattr(llvm, "_llvm_is_loaded", lambda: True)
    monkeypatch.setattr(ExtensionFileLoader, "create_module", lambda loader, spec: flags.append(sys.getdlopenflags()))
    before = sys.getdlopenflags()
    spec = compiled()
    spec.loader.create_module(spec)
    assert flags == [before | os.RTLD_DEEPBIND]
    assert sys.getdlopenflags() == before


def test_without_another_llvm_triton_is_loaded_as_ever(compiled, monkeypatch):
    monkeypatch.setattr(llvm, "_llvm_is_loaded", lambda: False)
    assert compiled() is None


def test_beside_a_malloc_of_somebody_elses_triton_is_refused_as_if_missing(compiled, monkeypatch):
    monkeypatch.setattr(llvm, "_llvm_is_loaded", lambda: True)
    monkeypatch.setattr(llvm, "_malloc_of", {"libfast.so": 1, "libc.so.6": 2}.__getitem__)
    monkeypatch.setenv("LD_PRELOAD", "libfast.so")
    with pytest.raises(ImportError, match="import triton first"):
        compiled()


def test_a_preloaded_library_without_malloc_counts_for_none(monkeypatch):
    monkeypatch.setenv("LD_PRELOAD", "libm.so.6:/nowhere/libmissing.so")
    assert not llvm._malloc_is_replaced()
