"""A step of a mind, compiled: in a file of its own, for whatever stands beside compiled code is compiled with it."""

from jointattn_mj.development.loop import think_and_note
from jointattn_mj.io.compiled import njit


@njit(cache=True)
def think_once(agent, s, r, t, first, log, samples, every):
    """See ``think_and_note``."""
    return think_and_note(agent, s, r, t, first, log, samples, every)
