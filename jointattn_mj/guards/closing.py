"""What has been closed says so in one line, whatever it is asked for; until then that costs nothing."""

from typing import TYPE_CHECKING, Any, TypeVar

from jointattn_mj.errors import ClosedError

Kind = TypeVar("Kind", bound="Closable")


class Closable:
    """A class whose ``close`` ends with ``_shut``."""

    def _shut(self) -> None:
        """Forget all attributes; from now on every one of them, and every copy, is a ``ClosedError``."""
        vars(self).clear()
        vars(self)["_closed"] = True

    @property
    def closed(self) -> bool:
        """Whether ``close`` has been called."""
        return "_closed" in vars(self)

    if not TYPE_CHECKING:  # type checkers would take any attribute to be there

        def __getattr__(self, name: str) -> Any:
            """Called for attributes that are not there."""
            if self.closed and not name.startswith("__"):
                raise ClosedError(f"this {type(self).__name__} is closed; make another")
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")


def closed_one(kind: type[Kind]) -> Kind:
    """One of a class that is closed from the start: the copy of another."""
    made = kind.__new__(kind)
    made._shut()
    return made
