"""Chooses the OpenGL backend that MuJoCo renders with, once, when something first imports mujoco.

A backend is software (EGL or OSMesa, both through Mesa) or a GPU driver's EGL. MuJoCo reads ``MUJOCO_GL`` when it is
imported, and ends in a traceback there where a library or a driver is missing; this module tries both first. Where no
image can be rendered all else works, and the first image that is asked for raises an error that says why.
"""

import os
import sys
import warnings
from collections.abc import Sequence
from types import ModuleType

DISABLED = ("disable", "disabled", "off", "false", "0")
WINDOWED = ("glfw", "glx", "enable", "enabled", "on", "true", "1")
CHOICES = ("", "egl", "osmesa", *WINDOWED, *DISABLED)
"""Values of ``MUJOCO_GL`` that MuJoCo takes on Linux, in any case; dm_control wants small letters, and knows no glx."""
EGL_PLATFORM_DEVICE = 0x313F
DEVICE = "MUJOCO_EGL_DEVICE_ID"
"""Names the one device that EGL is to open, by its number."""
READERS = ("mujoco", "dm_control")
"""Packages that read ``MUJOCO_GL`` when they are imported."""
LIBRARIES = {"egl": ("libEGL.so.1", "libOpenGL.so.0"), "osmesa": ("libOSMesa.so.8", "libOSMesa.so")}

WITHOUT = "Without images, `--perception state` works as it is."
INSTALL = (
    "Install one of these and start again:\n"
    "  EGL:    apt-get install --no-install-recommends libegl1 libopengl0 libgl1-mesa-dri\n"
    "  OSMesa: apt-get install --no-install-recommends libosmesa6, then set MUJOCO_GL=osmesa\n"
    f"{WITHOUT}"
)

_refused = ""
"""Why the backend that the user names is not taken."""


def why_not() -> str:
    """Why rendering is disabled, and what to do: nothing is to be installed where only ``MUJOCO_GL`` is in the way."""
    works = next((backend for backend in LIBRARIES if available(backend)), None)
    if works is None:
        return f"{_refused or 'Images need an OpenGL library, and none that works was found.'} {INSTALL}"
    return f"{_refused or 'MUJOCO_GL turns rendering off.'} {works} works here: leave MUJOCO_GL out. {WITHOUT}"


def _loads(name: str) -> bool:
    import ctypes

    try:
        ctypes.CDLL(name)
    except OSError:
        return False
    return True


def _egl_opens() -> bool:
    """Whether EGL opens a display, as dm_control will: the library does nothing without Mesa's or a GPU's driver."""
    import ctypes

    egl = ctypes.CDLL(LIBRARIES["egl"][0])
    pointer, number = ctypes.c_void_p, ctypes.c_int
    egl.eglGetProcAddress.restype = pointer
    egl.eglInitialize.argtypes = (pointer, pointer, pointer)
    query, open_display = map(egl.eglGetProcAddress, (b"eglQueryDevicesEXT", b"eglGetPlatformDisplayEXT"))
    if not (query and open_display):
        return False
    devices, count = (pointer * 16)(), number()
    ctypes.CFUNCTYPE(number, number, pointer, pointer)(query)(16, devices, ctypes.byref(count))
    chosen = os.environ.get(DEVICE)
    try:
        numbers = [index for index in range(count.value) if chosen is None or index == int(chosen)]
    except ValueError:  # and MuJoCo would end in a traceback
        return False
    display_of = ctypes.CFUNCTYPE(pointer, number, pointer, pointer)(open_display)
    displays = (display_of(EGL_PLATFORM_DEVICE, devices[index], None) for index in numbers)
    return any(display and egl.eglInitialize(display, None, None) for display in displays)


def _window_opens() -> bool:
    """Whether there is a display to open a window on, which GLFW needs even for images that are not shown."""
    try:
        import glfw
    except (ImportError, OSError):
        return False
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return bool(glfw.init())


def available(backend: str) -> bool:
    """Whether a backend ("egl", "osmesa" or "glfw") can be used: its libraries load, and it opens a display."""
    if backend == "glfw":
        return _window_opens()
    if backend == "egl":
        return all(_loads(name) for name in LIBRARIES["egl"]) and _egl_opens()
    return any(_loads(name) for name in LIBRARIES["osmesa"])


class _Chooser:
    """An import hook that finds no module, but chooses a backend before the first of ``READERS`` is imported."""

    chosen = False

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> None:
        if name in READERS and not self.chosen:
            self.chosen = True
            choose_backend()


def choose_when_needed() -> None:
    """Choose a backend when mujoco or dm_control is first imported; until then no OpenGL library is touched."""
    if any(name in sys.modules for name in READERS):
        choose_backend()
    else:
        sys.meta_path.insert(0, _Chooser())


def choose_backend() -> None:
    """Set ``MUJOCO_GL`` where the user has not. EGL comes first, since Mesa 25.1 dropped OSMesa.

    Where no backend works, or not the one that the user names, rendering is disabled, and the import of mujoco still
    works; ``why_not`` tells the reason.
    """
    if sys.platform != "linux":
        return
    chosen = os.environ.get("MUJOCO_GL", "").lower().strip()
    chosen = "glfw" if chosen in WINDOWED else chosen
    if not chosen:
        os.environ["MUJOCO_GL"] = next((backend for backend in LIBRARIES if available(backend)), "disable")
        if DEVICE in os.environ and rendering_disabled():
            _disable(_no_device())
    elif chosen not in CHOICES:
        _disable(f"MUJOCO_GL={chosen} was asked for, which is no way to render; egl and osmesa are.")
    elif chosen == "egl" and DEVICE in os.environ and not available(chosen):
        _disable(_no_device())
    elif chosen in LIBRARIES and not available(chosen):
        _disable(f"MUJOCO_GL={chosen} was asked for, but {LIBRARIES[chosen][0]} cannot be loaded, or has no driver.")
    elif chosen == "glfw" and not available(chosen):
        _disable("MUJOCO_GL=glfw was asked for, but there is no display to open a window on.")
    else:
        os.environ["MUJOCO_GL"] = chosen


def _no_device() -> str:
    return f"{DEVICE}={os.environ[DEVICE]!r:.80} is no device that EGL opens here: leave it out."


def _disable(refused: str) -> None:
    global _refused
    _refused, os.environ["MUJOCO_GL"] = refused, "disable"


def rendering_disabled() -> bool:
    """Whether mujoco was told not to render at all."""
    return os.environ.get("MUJOCO_GL", "").lower().strip() in DISABLED
