"""Physics whose images any thread may draw, and which says in one line why there are none.

An OpenGL context belongs to the thread that it is current in. dm_control leaves it there: an image from another
thread, and ``close`` or garbage collection in one, end in tracebacks. Here a context is current while something is
drawn and no longer, which costs 8 microseconds an image. In a process that was forked from one that has rendered,
OpenGL cannot go on: contexts are left alone there.
"""

import atexit
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any
from weakref import WeakSet

from dm_control import _render, mujoco
from dm_control._render import base
from dm_control.mujoco import engine, wrapper

from jointattn_mj.errors import GLError
from jointattn_mj.guards.closing import Closable
from jointattn_mj.scene import gl

FORKED = "a process cannot render that was forked from one that has; start it by spawn or forkserver"


class RenderingPhysics(Closable, mujoco.Physics):
    """dm_control's physics with contexts of that kind; one thread at a time."""

    def free(self) -> None:
        """Free data and contexts; whatever the physics is asked for afterwards is a ``ClosedError``."""
        if not self.closed:
            super().free()
            self._shut()

    def _make_rendering_contexts(self) -> None:
        """See ``mujoco.Physics``.

        Raises:
            GLError: No image can be rendered here; the message says why, and names the packages to install.
        """
        if gl.rendering_disabled():
            raise GLError(gl.why_not())
        if _forked:
            raise GLError(FORKED)
        size = self.model.vis.global_
        try:
            context = _context_class()(size.offwidth, size.offheight)
            self._contexts = engine.Contexts(gl=context, mujoco=_MjrContext(self.model, context))
        except Exception as error:  # PyOpenGL, mujoco and dm_control raise a dozen kinds here
            raise GLError(f"The OpenGL library could not open an offscreen image ({error}). {gl.INSTALL}") from error


class _MjrContext(wrapper.MjrContext):
    """One that was never made has nothing to free, and does not complain of that."""

    _ptr = staticmethod(lambda: None)


_forked: list[Any] = []
"""What a forked process has of its parent's contexts; never freed."""
_open: WeakSet[Any] = WeakSet()


def _leave_alone() -> None:
    """After a fork, in the child: whatever is done with its parent's contexts touches no OpenGL."""
    if _render.BACKEND == "egl":
        from dm_control._render.pyopengl import egl_ext as egl

        atexit.unregister(egl.eglTerminate)
    for context in list(_open):
        _forked.append((context, list(context._patients)))
        context._render_executor._terminated = True


@cache
def _context_class() -> type[Any]:
    os.register_at_fork(after_in_child=_leave_alone)

    class Context(_render.Renderer):  # type: ignore[misc, name-defined]
        def __init__(self, width: int, height: int):
            super().__init__(width, height)
            _open.add(self)

        @contextmanager
        def make_current(self) -> Iterator[Any]:
            if _forked:
                raise GLError(FORKED)
            with _lent(self) if _render.BACKEND == "egl" else super().make_current() as thread:
                yield thread

    return Context


@contextmanager
def _lent(context: Any) -> Iterator[Any]:
    """Current in this thread while the block runs, and in none afterwards."""
    from dm_control._render.pyopengl import egl_ext as egl
    from dm_control._render.pyopengl.egl_renderer import EGL_DISPLAY

    with context._render_executor.execution_context() as executor:
        other = base._CURRENT_CONTEXT_FOR_THREAD.pop(threading.current_thread(), None)
        base._CURRENT_THREAD_FOR_CONTEXT.pop(other, None)  # it will have to become current again
        context._platform_make_current()
        try:
            yield executor
        finally:
            egl.eglMakeCurrent(EGL_DISPLAY, egl.EGL_NO_SURFACE, egl.EGL_NO_SURFACE, egl.EGL_NO_CONTEXT)
