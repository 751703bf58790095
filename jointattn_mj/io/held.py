"""Tuples of arrays that compiled code has been handed once.

Python hands a tuple over array by array, half a microsecond each: for the agent of chapter 5, 35 microseconds a call.
A held tuple is handed over as one thing.
"""

from typing import TYPE_CHECKING, Any

from numba import config
from numba.core import types
from numba.experimental import structref

_PLAIN: bool = config.DISABLE_JIT  # type: ignore[attr-defined]  # then functions are not compiled


class Held(structref.StructRefProxy):
    """A tuple in compiled code's keeping. Its arrays are shared, and stay as long as it does.

    To be made by a compiled function of the tuple, ``Held(value)``, which is stored with the others; Python would
    compile it in every process.
    """

    value: Any
    """The tuple, for compiled code alone."""

    if TYPE_CHECKING or _PLAIN:

        def __new__(cls, value: Any) -> "Held":
            """Keep a tuple."""
            held: Held = object.__new__(cls)
            held.value = value
            return held


if not _PLAIN:

    @structref.register
    class _HeldType(types.StructRef):
        """Numba's type of ``Held``."""

    structref.define_proxy(Held, _HeldType, ["value"])  # type: ignore[no-untyped-call]
