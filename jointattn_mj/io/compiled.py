"""``njit`` with a store of compiled functions that notices what was inlined into them.

numba takes a stored function for current as long as the file that it stands in has not changed. What was inlined into
it from other files may have changed all the same, and an old mixture would run on, silently. Here a stored function is
current as long as no file of the package with compiled functions has changed. Functions of others are not touched.
"""

import hashlib
from collections.abc import Callable
from contextlib import suppress
from functools import cache, partial
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar, overload

import numba
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.dispatcher import Dispatcher
from numba.core.environment import Environment, lookup_environment
from numba.core.runtime.nrt import rtsys

Function = Callable[..., Any]
F = TypeVar("F", bound=Function)
PACKAGE = Path(__file__).parents[1]


@overload
def njit(function: F, /) -> F: ...


@overload
def njit(*, cache: bool = ..., borrows: bool = ..., **options: Any) -> Callable[[F], F]: ...


def njit(function: Function | None = None, *, cache: bool = False, borrows: bool = False, **options: Any) -> Any:
    """``numba.njit``, to be used in its place.

    Args:
        function: What to compile; None where the decorator has options.
        cache: Store the compiled function in numba's folder for it: ``__pycache__`` beside the file, a folder of the
            user where that cannot be written, or what NUMBA_CACHE_DIR names. Where none can be written, it is compiled
            again by every process.
        borrows: For a function that makes no array: compiled code calls it without counting references to the arrays
            that it is given (see ``Borrowing``).
        options: numba's.
    """
    if function is None:
        return partial(njit, cache=cache, borrows=borrows, **options)
    if borrows:
        return Borrowing(function, cache, options)
    options["no_cfunc_wrapper"] = True  # a form for C, which nobody calls: 4% of the time to compile
    compiled = numba.njit(**options)(function)
    if cache and isinstance(compiled, Dispatcher):  # with NUMBA_DISABLE_JIT it is the function itself
        with suppress(RuntimeError):  # no folder
            compiled._cache = _Cache(function)  # type: ignore[attr-defined]  # as ``enable_caching``
    return compiled


class Borrowing:
    """A compiled function that makes no array; numba refuses one that does.

    Numba counts references to each array of a tuple wherever the tuple is handed on: with the agent of chapter 5, .4 of
    the .5 microseconds that a step without counting takes. Compiled code calls a form of the function that counts none.
    Python calls the common form: without counts numba would never let go of a random generator that Python hands over.
    """

    def __init__(self, function: Function, cache: bool, options: dict[str, Any]):
        self._counted = njit(cache=cache, **options)(function)
        copy = FunctionType(function.__code__, function.__globals__, function.__name__, function.__defaults__)
        copy.__qualname__ = f"{function.__qualname__}.borrowed"  # the name under which it is stored
        self._borrowed: Any = njit(cache=cache, _nrt=False, **options)(copy)
        self.__doc__, self.__name__ = function.__doc__, function.__name__

    @property
    def _numba_type_(self) -> Any:
        return self._borrowed._numba_type_

    def __call__(self, *arguments: Any) -> Any:
        """Call from Python."""
        return self._counted(*arguments)


@cache
def state(package: Path = PACKAGE) -> str:
    """A digest that changes with any file of the package in which something is compiled."""
    digest = hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        text = path.read_bytes()
        if b"njit" in text:
            digest.update(str(path.relative_to(package)).encode() + b"\0" + text)
    return digest.hexdigest()


class _Located(CompileResultCacheImpl):
    """Chooses the folder as numba does; what it holds is current while ``state`` stays the same."""

    def __init__(self, function: Function):
        super().__init__(function)  # type: ignore[no-untyped-call]
        self._locator.get_source_stamp = state

    def reduce(self, result: Any) -> tuple[Any, ...]:
        """What is stored of a compiled function: of numba's functions in it, not the modules that they come from."""
        *parts, environments = super().reduce(result)  # type: ignore[no-untyped-call]
        return *parts, [(e.globals["__name__"], list(e.consts), e.env_name) for e in environments]

    def rebuild(self, target_context: Any, stored: tuple[Any, ...]) -> Any:
        """The compiled function of what ``reduce`` gave."""
        *parts, environments = stored
        return super().rebuild(target_context, (*parts, [_environment(*e) for e in environments]))  # type: ignore[no-untyped-call]


def _environment(module: str, consts: list[Any], name: str) -> Environment:
    """Constants of a function that was compiled without Python's objects, which reads no globals."""
    known: Environment | None = lookup_environment(name)  # type: ignore[no-untyped-call]
    if known is None:
        known = Environment._memo[name] = Environment({"__name__": module})
        known.consts[:] = consts
        known.env_name = name
    return known


class _Cache(FunctionCache):
    """Reads no index of another state of the package: classes that it names may be gone."""

    _impl_class = _Located

    def __init__(self, function: Function):
        super().__init__(function)  # type: ignore[no-untyped-call]
        self._cache_file._version = f"{numba.__version__} {state()}"

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """A stored function, or None.

        numba first loads all that it needs to compile, scipy.linalg with it: .25 s and 40 MiB. A stored function needs
        numba's runtime and no more; what is compiled loads the rest by itself.
        """
        rtsys.initialize(target_context)
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)  # type: ignore[no-untyped-call]
