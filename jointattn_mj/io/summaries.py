"""The base of all summaries: a few numbers of a finished run, as attributes here and as JSON in its folder."""

import json
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, ClassVar, Self, get_args, get_origin, get_type_hints

from jointattn_mj.errors import OutputError
from jointattn_mj.io.files import write_whole
from jointattn_mj.io.provenance import plain
from jointattn_mj.options import warn_of_old, warn_renamed

WIDTH = 110
"""Characters of a summary's repr."""


class Summary:
    """Base of frozen dataclasses that hold a run's numbers; a field may be a summary itself.

    Fields are read as attributes. ``summary["name"]`` does the same; a key that an earlier version used gives its value
    and a ``RenamedWarning`` that names the new one. ``str`` is a table with a field a line, ``repr`` fits one line.
    """

    RENAMED: ClassVar[Mapping[str, str]] = {}
    """Keys of the last version, and what they are called now."""

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Self:
        """The summary whose :meth:`plain` values are given, by names of this version or, with a warning, of the last.

        Args:
            values: A value for every field.

        Returns:
            The summary.

        Raises:
            OutputError: A field is missing, or there is one too many.

        Examples:
            >>> from jointattn_mj import Session, SessionSummary
            >>> summary = Session(minutes=0.1, perception="state").run().summary
            >>> SessionSummary.of(summary.plain()) == summary
            True
        """
        hints, known = get_type_hints(cls), {field.name for field in fields(cls)}  # type: ignore[arg-type]
        for old, name in cls.RENAMED.items():
            if old in values:
                warn_renamed(f"{cls.__name__}.{old}", name)
        named = {cls.RENAMED.get(name, name): value for name, value in values.items()}
        if named.keys() != known:
            wrong = ", ".join(sorted(known ^ named.keys()))
            raise OutputError(f"expected {', '.join(hints)} in a summary; missing or unknown: {wrong}")
        return cls(**{name: _nested(hints[name], value) for name, value in named.items()})

    @classmethod
    def read(cls, path: Path) -> Self:
        """The summary in a ``summary.json``.

        Args:
            path: The file.

        Returns:
            The summary, equal to the one that was written.

        Raises:
            OutputError: There is no such file, or it holds no such summary.

        Examples:
            >>> from jointattn_mj import Session, SessionSummary
            >>> result = Session(minutes=0.1, perception="state").run(out="out/summarised")
            >>> SessionSummary.read(result.folder / "summary.json") == result.summary
            True
        """
        try:
            return cls.of(json.loads(path.read_text("utf-8")))
        except FileNotFoundError as error:
            raise OutputError(f"there is no {path}; give the folder of a finished run") from error
        except (OSError, ValueError, TypeError, AttributeError) as error:
            raise OutputError(f"cannot read {path} ({error}); give the folder of a finished run") from error

    def write(self, path: Path) -> None:
        """Write ``summary.json``, whole or not at all.

        Args:
            path: The file.

        Raises:
            OutputError: The file cannot be written.

        Examples:
            >>> from pathlib import Path
            >>> from jointattn_mj import Session
            >>> Session(minutes=0.1, perception="state").run().summary.write(Path("out/numbers.json"))
        """
        text = json.dumps(self.plain(), indent=1) + "\n"
        write_whole(path, lambda temporary: temporary.write_text(text))

    def plain(self) -> dict[str, Any]:
        """Give the summary as plain data.

        Returns:
            Numbers, texts and nested dictionaries: what ``summary.json`` holds.

        Examples:
            >>> from jointattn_mj import Session
            >>> Session(minutes=0.1, perception="state").run().summary.plain()["frames"]
            180
        """
        values: dict[str, Any] = plain(self)
        return values

    def by_old_keys(self) -> dict[str, Any]:
        """Give the summary as plain data under the keys of the last version, as trials are stored.

        Returns:
            What ``plain`` gives, by its former names.

        Examples:
            >>> from jointattn_mj import Session
            >>> "late_rate" in Session(minutes=0.1, perception="state").run().summary.by_old_keys()
            True
        """
        old = {new: key for key, new in self.RENAMED.items()}
        values = {field.name: getattr(self, field.name) for field in fields(self)}  # type: ignore[arg-type]
        return {old.get(name, name): _by_old_keys(value) for name, value in values.items()}

    def __getitem__(self, key: str) -> Any:
        """The value of a field.

        Raises:
            KeyError: There is no such field.
        """
        if key in self.RENAMED:
            new = self.RENAMED[key]
            warn_of_old(f"the summary's {key!r} is now called {new!r}")
            key = new
        names = [field.name for field in fields(self)]  # type: ignore[arg-type]
        if key not in names:
            raise KeyError(f"a {type(self).__name__} has no {key!r}; there are {', '.join(names)}")
        return getattr(self, key)

    def __repr__(self) -> str:
        start = f"{type(self).__name__}("
        text, room = ", ".join(f"{name}={_short(value)}" for name, value in _leaves(self)), WIDTH - len(start) - 1
        return f"{start}{text if len(text) <= room else text[: text.rindex(',', 0, room - 4)] + ', ...'})"

    def __str__(self) -> str:
        rows = list(_leaves(self))
        width = max(len(name) for name, _ in rows)
        return "\n".join(f"{name.ljust(width)}  {_short(value)}" for name, value in rows)


def _nested(hint: Any, value: Any) -> Any:
    """A field's value by its type: a summary, perhaps, or a tuple, which JSON knows as a list."""
    for kind in get_args(hint) or (hint,):
        if isinstance(kind, type) and issubclass(kind, Summary) and isinstance(value, Mapping):
            return kind.of(value)
    return tuple(value) if get_origin(hint) is tuple and isinstance(value, list) else value


def _by_old_keys(value: Any) -> Any:
    return value.by_old_keys() if isinstance(value, Summary) else value


def _leaves(summary: Any, before: str = "") -> Any:
    for field in fields(summary):
        value = getattr(summary, field.name)
        if is_dataclass(value):
            yield from _leaves(value, f"{before}{field.name}.")
        else:
            yield f"{before}{field.name}", value


def _short(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
