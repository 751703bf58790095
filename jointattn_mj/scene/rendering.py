"""A physics that any thread may render, and that says in one line why it cannot.

An OpenGL context belongs to the thread in which it is current. dm_control leaves it current, so that an image,
``close`` or garbage collection in another thread ends in a traceback. Here a context is current only while something is
drawn, which costs 20 microseconds an image. A process that was forked from one that has rendered cannot use OpenGL, and
leaves its parent's contexts alone.
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
from jointattn_mj.scene import gl, native

FORKED = "a process cannot render that was forked from one that has; start it by spawn or forkserver"


class RenderingPhysics(Closable, mujoco.Physics):  # type: ignore[misc]
    """dm_control's physics, to be used from any thread, by one thread at a time."""

    def free(self) -> None:
        """Free data and contexts. Any use of the physics afterwards raises ``ClosedError``."""
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


class _MjrContext(wrapper.MjrContext):  # type: ignore[misc]
    """A context that has nothing to free, without complaint, where it was never made."""

    _ptr = staticmethod(lambda: None)


_forked: list[Any] = []
"""In a forked process, its parent's contexts; they are never freed."""
_open: WeakSet[Any] = WeakSet()


def _leave_alone() -> None:
    """After a fork, in the child: keep its parent's contexts from touching OpenGL."""
    if _render.BACKEND == "egl":
        from dm_control._render.pyopengl import egl_ext as egl

        atexit.unregister(egl.eglTerminate)
    for context in list(_open):
        _forked.append((context, list(context._patients)))
        context._render_executor._terminated = True


@cache
def _context_class() -> type[Any]:
    os.register_at_fork(after_in_child=_leave_alone)

    class Context(_render.Renderer):  # type: ignore[misc]
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
    """Make a context current in this thread for the block, and in none afterwards."""
    with context._render_executor.execution_context() as executor:
        other = base._CURRENT_CONTEXT_FOR_THREAD.pop(threading.current_thread(), None)
        base._CURRENT_THREAD_FOR_CONTEXT.pop(other, None)  # it will have to become current again
        if not native.make_current(context._context.address):
            context._platform_make_current()  # raises EGL's own error
        try:
            yield executor
        finally:
            native.make_current(None)
