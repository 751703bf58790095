"""Named tuples whose instances compiled code takes for one type without looking."""

from typing import TypeVar

from numba import types
from numba.extending import typeof_impl

Kind = TypeVar("Kind", bound=type)


def one_type(kind: Kind) -> Kind:
    """Decorate a named tuple, all of whose instances are of one type for numba, which would work it out field by field
    at each call, in up to sixty times the time of a turn."""
    known: list[types.Type] = []

    @typeof_impl.register(kind)
    def type_of(value, context):
        if not known:
            known.append(typeof_impl.dispatch(tuple)(value, context))
        return known[0]

    return kind
