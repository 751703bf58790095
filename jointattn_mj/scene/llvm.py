"""Lets Mesa and triton, which PyTorch brings on Linux, be in one process whichever comes first.

Both contain LLVM, in different versions. Mesa's software renderer makes the symbols of its LLVM global when the first
OpenGL context is opened. A triton that is loaded later is bound to them instead of to its own, and the process crashes
in triton's initialisers (Mesa 22.3 with LLVM 15 and triton 3.7: 12,491 symbols of libtriton.so bound to
libLLVM-15.so.1). Loaded with RTLD_DEEPBIND, triton is bound to its own first.
"""

import os
import sys
from collections.abc import Sequence
from importlib.machinery import ExtensionFileLoader, ModuleSpec, PathFinder
from types import ModuleType

COMPILED = "triton._C."
"""Package of triton's compiled modules."""


def keep_apart() -> None:
    """Load triton's compiled modules bound to their own LLVM; until they are imported nothing is touched."""
    if sys.platform == "linux" and hasattr(os, "RTLD_DEEPBIND"):
        sys.meta_path.insert(0, _TritonFinder())


class _TritonFinder:
    """An import hook that gives triton's compiled modules another loader."""

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        if not name.startswith(COMPILED) or not _llvm_is_loaded():
            return None
        spec = PathFinder.find_spec(name, path, target)
        if spec is None or not isinstance(spec.loader, ExtensionFileLoader):
            return None
        if _malloc_is_replaced():  # bound to libc's free first, triton would free what the other malloc gave
            raise ImportError("triton cannot be loaded after OpenGL beside a preloaded malloc; import triton first")
        spec.loader = _BoundToItself(spec.loader.name, spec.loader.path)
        return spec


class _BoundToItself(ExtensionFileLoader):
    def create_module(self, spec: ModuleSpec) -> ModuleType:
        flags = sys.getdlopenflags()
        sys.setdlopenflags(flags | os.RTLD_DEEPBIND)
        try:
            return super().create_module(spec)
        finally:
            sys.setdlopenflags(flags)


def _llvm_is_loaded() -> bool:
    """Whether an LLVM that is not triton's is in this process."""
    with open("/proc/self/maps", encoding="utf-8", errors="replace") as maps:
        return "libLLVM" in maps.read()


def _malloc_is_replaced() -> bool:
    """Whether LD_PRELOAD has put another malloc before libc's: jemalloc, say."""
    preloaded = os.environ.get("LD_PRELOAD", "").replace(":", " ").split()
    return any(_malloc_of(library) not in (None, _malloc_of("libc.so.6")) for library in preloaded)


def _malloc_of(library: str) -> int | None:
    """Address of the malloc that a library uses, or None where there is no such library."""
    import ctypes

    try:
        return ctypes.cast(ctypes.CDLL(library).malloc, ctypes.c_void_p).value
    except OSError:
        return None
