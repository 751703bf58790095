"""Which OpenGL backend MuJoCo renders with: chosen once, before anything imports mujoco.

A backend is software (EGL or OSMesa, both through Mesa) or a GPU driver's EGL. MuJoCo reads ``MUJOCO_GL`` when it is
imported and fails there with a loader's traceback when the library is missing; this file asks the loader first.
"""

import ctypes
import os
import sys

from jointattn_mj.errors import GLError

LIBRARIES = {"egl": ("libEGL.so.1", "libOpenGL.so.0"), "osmesa": ("libOSMesa.so.8", "libOSMesa.so")}

INSTALL = (
    "Install one of these and start again:\n"
    "  EGL:    apt-get install --no-install-recommends libegl1 libopengl0 libgl1-mesa-dri\n"
    "  OSMesa: apt-get install --no-install-recommends libosmesa6, then set MUJOCO_GL=osmesa\n"
    "Without pictures, `--perception truth` works as it is."
)


def _loads(name: str) -> bool:
    try:
        ctypes.CDLL(name)
    except OSError:
        return False
    return True


def available(backend: str) -> bool:
    """Whether the shared libraries of ``backend`` ("egl" or "osmesa") load."""
    if backend == "egl":
        return all(_loads(name) for name in LIBRARIES["egl"])
    return any(_loads(name) for name in LIBRARIES["osmesa"])


def choose_backend() -> None:
    """Set ``MUJOCO_GL`` where the user has not; EGL first, for Mesa 25.1 dropped OSMesa.

    With neither library on the machine rendering is disabled rather than the import of mujoco broken.

    Raises:
        GLError: The user named a backend whose library does not load.
    """
    if sys.platform != "linux":
        return
    chosen = os.environ.get("MUJOCO_GL", "").lower().strip()
    if not chosen:
        found = next((backend for backend in LIBRARIES if available(backend)), "disable")
        os.environ["MUJOCO_GL"] = found
    elif chosen in LIBRARIES and not available(chosen):
        raise GLError(f"MUJOCO_GL={chosen} was asked for, but {LIBRARIES[chosen][0]} cannot be loaded. {INSTALL}")


def rendering_disabled() -> bool:
    """Whether mujoco was told not to render at all."""
    return os.environ.get("MUJOCO_GL", "").lower().strip() in ("disable", "disabled", "off", "false", "0")
