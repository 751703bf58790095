"""How a config says what its fields may be, and the one place where that is checked.

A config is a frozen dataclass that inherits from :class:`Checked`. The annotation of a field says all: its type,
``Literal`` choices, or a marker in ``Annotated``, such as ``Annotated[float, Real("(0, 1]")]``. The command line lists
choices and intervals in ``--help``. What concerns several fields at once stays in the config's own ``__post_init__``,
after ``super().__post_init__()``.

Names that a field or a choice had in the last version stand in ``RENAMED`` and ``OLD_CHOICES`` of the config, fields
that it has no more in ``GONE``. They are taken with a :class:`RenamedWarning` from Python, from the command line and
from config files.
"""

import inspect
import os
import re
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import MISSING, Field, dataclass, fields, replace
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, ClassVar, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import tyro
from tyro.constructors import PrimitiveConstructorSpec

from jointattn_mj.errors import ConfigError

Config = TypeVar("Config", bound="Checked")
TOP_LEVEL = tyro.conf.arg(prefix_name=False)
"""An option that many use: `--caregiver`, not `--world.scene.caregiver`."""
FLAT = tyro.conf.arg(name="")
"""A parameter of a command whose fields are options without a prefix."""

UNITS = {
    "deg_s": "degrees per second", "m_s": "metres per second", "deg": "degrees", "px": "pixels", "s": "seconds",
    "m": "metres", "hz": "hertz", "minutes": "minutes", "frames": "frames",
}  # fmt: skip
"""What the end of a field's name says about its unit."""
GOES = "; the old name goes with the next version"
"""Ends what is said of an old name."""
_INSIDE = (__name__.partition(".")[0], "dataclasses")
"""Where a warning of an old name does not point to."""
LONGEST_NAME, LONGEST_PATH = 255, 4095
"""Bytes in a file's name and in a path on Linux."""


class Interval(PrimitiveConstructorSpec[Any]):
    """Marks a number that lies in an interval, written as ``(0, 1]``: without 0, with 1. Its bounds are finite."""

    kind: ClassVar[type]
    name: ClassVar[str]

    def __init__(self, interval: str):
        match = re.fullmatch(r"([\[(]) *(\S+), *(\S+?)([\])])", interval)
        if match is None:
            raise ValueError(f"an interval is written as [0, 1) or (0, 1]; got {interval!r}")
        self.low, self.high = (self.kind(float(bound)) for bound in match.group(2, 3))
        self.closed = match[1] == "[", match[4] == "]"
        self.interval, self.words = interval, f"a {self.name} in {interval}"
        super().__init__(
            nargs=1,
            metavar=("INT" if self.kind is int else "FLOAT") + interval.replace(" ", ""),
            instance_from_str=lambda texts: self._read(texts[0]),
            is_instance=lambda value: self.fit(value) is not UNFIT,
            str_from_instance=lambda value: [str(value)],
        )

    def fit(self, value: Any) -> Any:
        """The number as a config keeps it, or UNFIT."""
        if isinstance(value, bool) or not isinstance(value, int if self.kind is int else (int, float)):
            return UNFIT
        above = value >= self.low if self.closed[0] else value > self.low
        below = value <= self.high if self.closed[1] else value < self.high
        return value if above and below else UNFIT  # NaN is neither

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.interval!r})"

    def _read(self, text: str) -> Any:
        try:
            return self.kind(text)
        except ValueError:
            raise ValueError(f"expected {self.words}; got {shown(text)}") from None


class Real(Interval):
    """Marks a ``float`` field; whole numbers stay as they are."""

    kind, name = float, "number"


class Whole(Interval):
    """Marks an ``int`` field."""

    kind, name = int, "whole number"


class Choice(PrimitiveConstructorSpec[str]):
    """Marks a ``str`` field that is one of the names in a registry. Where they can be written out, use ``Literal``.

    Args:
        names: The choices.
        joined: What stands between two, where several may be chosen: ``Choice(names, "+")``.
        other_names: Further names by what they stand for; accepted in any case, and kept as the choice.
    """

    def __init__(self, names: Iterable[str], joined: str = "", other_names: Mapping[str, str] | None = None):
        self.names, self.joined = tuple(names), joined
        self.other_names = {other.lower(): name for other, name in (other_names or {}).items()}
        self.words = f"some of {', '.join(self.names)}, joined by {joined}" if joined else _one_of(self.names)
        super().__init__(
            nargs=1,
            metavar=f"{{{','.join(self.names)}}}{f'[{joined}...]' if joined else ''}",
            instance_from_str=lambda texts: texts[0],
            is_instance=lambda value: self.fit(value) is not UNFIT,
            str_from_instance=lambda value: [value],
            choices=None if joined or other_names else self.names,
        )

    def __repr__(self) -> str:
        return f"Choice({self.names!r}{f', {self.joined!r}' if self.joined else ''})"

    def fit(self, value: Any) -> Any:
        """The text as a config keeps it, or UNFIT."""
        if not isinstance(value, str):
            return UNFIT
        if self.joined:
            return value if set(value.split(self.joined)) <= set(self.names) else UNFIT
        return value if value in self.names else self.other_names.get(value.lower(), UNFIT)


Share = Annotated[float, Real("[0, 1]")]
Positive = Annotated[float, Real("[1e-9, 1e9]")]
"""May be divided by."""
NotNegative = Annotated[float, Real("[0, 1e9]")]
Angle = Annotated[float, Real("[-180, 180]")]
"""Degrees."""
Spread = Annotated[float, Real("[0, 180]")]
"""Degrees: a standard deviation, a distance or a tolerance."""
Count = Annotated[int, Whole("[1, 1e9]")]
Seed = Annotated[int, Whole("[0, 9e18]")]
Seconds = Annotated[float, Real("(0, 3600]")]
"""How long a movement or a phase of behaviour takes."""
Metres = Annotated[float, Real("[-10, 10]")]
"""In the world frame."""
Colour = tuple[Share, Share, Share]
"""Red, green, blue."""


class RenamedWarning(FutureWarning):
    """A name of the last version was used; the message names the new one."""


class _ConfigType(type):
    """Lets configs be made with the names that their fields had in the last version."""

    def __call__(cls, *arguments: Any, **named: Any) -> Any:
        named = with_new_names(cls, named)
        check_names(cls.__name__, named, _arguments(cls))
        return super().__call__(*arguments, **named)

    @property
    def __signature__(cls) -> inspect.Signature:
        whole = inspect.signature(cls.__init__)  # type: ignore[misc]
        return whole.replace(parameters=list(whole.parameters.values())[1:])


@cache
def _arguments(config: type) -> tuple[str, ...]:
    """Names of what a config is made of."""
    return tuple(inspect.signature(config).parameters)


class Checked(metaclass=_ConfigType):
    """Base of every config: when one is made, each field is held against its annotation."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]
    RENAMED: ClassVar[Mapping[str, str]] = {}
    """Fields by the name that they had in the last version: ``{"mind": "agent"}``."""
    OLD_CHOICES: ClassVar[Mapping[str, Mapping[str, str]]] = {}
    """For a field (by its new name) its choices by their names in the last version:
    ``{"perception": {"truth": "state"}}``."""
    GONE: ClassVar[Sequence[str]] = ()
    """Fields of the last version that say nothing any more: they are left out."""
    ADVANCED: ClassVar[Sequence[str]] = ()
    """Fields that few people ever set: the command line lists them in --help-all only, last."""

    def __init_subclass__(cls) -> None:
        if "__repr__" not in vars(cls):
            cls.__repr__ = Checked.__repr__  # type: ignore[method-assign]  # or dataclass would write its own

    def __repr__(self) -> str:
        """What differs from the defaults, as the code that makes the config: ``SessionConfig(minutes=2, seed=3)``."""
        given = [
            f"{field.name}={getattr(self, field.name)!r}" for field in fields(self) if not _is_default(self, field)
        ]
        return f"{type(self).__name__}({', '.join(given)})"

    def __post_init__(self) -> None:
        """Check every field.

        Raises:
            ConfigError: One is of another type, out of its interval or none of its choices.
        """
        config = type(self)
        for name, rule in _rules(config):
            value = getattr(self, name)
            kept = rule.fit(_plain(value))
            if kept is UNFIT and (current := with_new_choice(config, name, value)) is not value:
                kept = rule.fit(current)
            if kept is UNFIT:
                raise ConfigError(
                    f"{config.__name__}.{name}: expected {rule.words}{_unit(name, rule)}; got {shown(value)}"
                    + meant(value, rule.choices)
                )
            if kept is not value:
                object.__setattr__(self, name, kept)


def _is_default(config: Checked, field: Field[Any]) -> bool:
    default = field.default if field.default_factory is MISSING else field.default_factory()
    value = getattr(config, field.name)
    return type(value) is type(default) and bool(value == default)


def changed(config: Config, given: Mapping[str, Any], location: str = "") -> Config:
    """A config with other values for the options that are given.

    Args:
        config: The config that stays as it is.
        given: New values by the names of fields; a mapping changes the fields of a config within. Options of parts that
            the command line takes without a prefix, such as ``caregiver``, go without one here, too.
        location: Dotted name of ``config`` with a dot at its end, for messages.

    Raises:
        ConfigError: No such field, or a value that is not allowed.
    """
    kind = type(config)
    given, inside = with_new_names(kind, given), {} if location else options_of_parts(kind)
    known = [*(field.name for field in fields(config)), *inside]
    values: dict[str, Any] = {}
    for name in sorted(given, key=inside.__contains__):  # whole parts first
        if name not in known:
            raise ConfigError(f"no option {location}{name}{meant(name, known)}; there are {', '.join(known)}")
        part, *path = (*inside.get(name, ()), name)
        value = given[name]
        for inner in reversed(path):
            value = {inner: value}
        before = values.get(part, getattr(config, part))
        nested = isinstance(value, Mapping) and isinstance(before, Checked)
        values[part] = changed(before, value, f"{location}{part}.") if nested else value
    try:
        return replace(config, **values)
    except ConfigError as error:
        raise ConfigError(str(error).replace(f"{kind.__name__}.", location, 1)) from error


@cache
def options_of_parts(config: type) -> dict[str, tuple[str, ...]]:
    """Options within the parts of a config that are ``TOP_LEVEL``: the fields that lead to each."""
    paths: dict[str, tuple[str, ...]] = {}
    for name, part in get_type_hints(config).items():
        if isinstance(part, type) and issubclass(part, Checked):
            hints = get_type_hints(part, include_extras=True)
            own = {inner: (name,) for inner, hint in hints.items() if TOP_LEVEL in get_args(hint)}
            paths |= own | {inner: (name, *path) for inner, path in options_of_parts(part).items()}
    return paths


def with_new_names(config: type, named: Mapping[str, Any], location: str | None = None) -> dict[str, Any]:
    """Values of fields by their names of today; warns of each that was named as in the last version, or is gone.

    Args:
        config: A class of configs.
        named: Values by the names of fields, new or old.
        location: What stands before a field's name in messages; None: the name of the class.

    Raises:
        TypeError: A field is named twice.
    """
    old, gone = old_names(config), _gone(config)
    before = f"{config.__name__}." if location is None else location
    current = {}
    for name, value in named.items():
        if name in gone:
            warn_of_old(f"{before}{name} is left out{GOES}")
            continue
        if name in old:
            if old[name] in named:
                raise TypeError(f"{before}{old[name]} is given twice: {name} is its old name")
            warn_renamed(f"{before}{name}", f"{'' if location is None else before}{old[name]}")
        current[old.get(name, name)] = value
    return current


def with_new_choice(config: type, name: str, value: Any, location: str | None = None) -> Any:
    """A choice by its name of today, or ``value`` itself; warns of a name of the last version.

    Args:
        config: A class of configs.
        name: One of its fields.
        value: Its value; in a tuple each part is a choice.
        location: What stands before the field's name in messages; None: the name of the class.
    """
    old = old_choices(config).get(name, {})
    before = f"{config.__name__}." if location is None else location
    for part in value if isinstance(value, tuple) else (value,):
        if isinstance(part, str) and part in old:
            warn_renamed(f"{before}{name} {part!r}", repr(old[part]))
            value = (
                tuple(old[part] if choice == part else choice for choice in value)
                if isinstance(value, tuple)
                else old[part]
            )
    return value


def warn_renamed(old: str, new: str) -> None:
    """Warn that ``old`` is called ``new`` now."""
    warn_of_old(f"{old} is now called {new}{GOES}")


def warn_of_old(message: str) -> None:
    """Warn of a name of the last version, at the line outside this package that has used it."""
    frame, level = sys._getframe(), 1
    while frame.f_back is not None and str(frame.f_globals.get("__name__")).partition(".")[0] in _INSIDE:
        frame, level = frame.f_back, level + 1
    warnings.warn(message, RenamedWarning, stacklevel=level)


@cache
def old_names(config: type) -> dict[str, str]:
    """``RENAMED`` of a class of configs and of those that it inherits from."""
    return {old: new for kind in reversed(config.__mro__) for old, new in vars(kind).get("RENAMED", {}).items()}


@cache
def _gone(config: type) -> frozenset[str]:
    return frozenset(name for kind in config.__mro__ for name in vars(kind).get("GONE", ()))


@cache
def old_choices(config: type) -> dict[str, Mapping[str, str]]:
    """``OLD_CHOICES`` of a class of configs and of those that it inherits from."""
    return {name: old for kind in reversed(config.__mro__) for name, old in vars(kind).get("OLD_CHOICES", {}).items()}


def shown(value: Any) -> str:
    """A value in an error message: on one line, and not long."""
    try:
        text = " ".join(repr(str(value) if isinstance(value, Path) else value).split())
    except Exception:  # Python writes no integer of more than 4300 digits, and an object's own words may fail
        text = f"a {type(value).__name__}{' of very many digits' if isinstance(value, int) else ''}"
    return text if len(text) <= 80 else f"{text[:60]}... ({len(text)} characters)"


def meant(value: Any, choices: Iterable[str]) -> str:
    """``(perhaps you meant 'min')``; nothing where no choice is like ``value``, or like the first of it that is odd.

    ``value`` is one choice, several that are joined by a +, a tuple of them, or something else.
    """
    choices = tuple(choices)
    for given in value.split("+") if isinstance(value, str) else value if isinstance(value, (tuple, list)) else ():
        if isinstance(given, str) and given not in choices:
            known = {choice.lower(): choice for choice in choices}
            near = get_close_matches(given.lower(), known, n=1)
            return f" (perhaps you meant {known[near[0]]!r})" if near else ""
    return ""


class _Unfit:
    """What :attr:`_Rule.fit` gives for a value that is not allowed; None may be."""


UNFIT = _Unfit()


@dataclass(frozen=True)
class _Rule:
    words: str
    """What is expected."""
    fit: Callable[[Any], Any]
    """The value as it is kept, or UNFIT."""
    choices: tuple[str, ...] = ()
    number: bool = False
    """Whether a unit makes sense."""


@cache
def _rules(config: type) -> tuple[tuple[str, _Rule], ...]:
    hints = get_type_hints(config, include_extras=True)
    return tuple((field.name, rule_of(hints[field.name])) for field in fields(config))


def rule_of(hint: Any) -> _Rule:
    """What an annotation allows."""
    if get_origin(hint) is Annotated:
        return _marked(*get_args(hint))
    if get_origin(hint) is Literal:
        names = get_args(hint)
        return _Rule(_one_of(names), lambda value: value if isinstance(value, str) and value in names else UNFIT, names)
    if get_origin(hint) in (Union, UnionType):
        return _any_of([rule_of(option) for option in get_args(hint)])
    if get_origin(hint) is tuple:
        return _tuple_of(get_args(hint))
    if hint is Path:
        return _Rule(f"a path, each part at most {LONGEST_NAME} bytes long", _path)
    if hint is str:
        return _Rule("text without NUL", lambda text: text if isinstance(text, str) and "\0" not in text else UNFIT)
    if hint is bool:
        return _Rule("True or False", lambda value: value if isinstance(value, bool) else UNFIT)
    if hint is NoneType:
        return _Rule("None", lambda value: value if value is None else UNFIT)
    if hint in (int, float):
        raise TypeError(f"a number needs an interval, such as Annotated[{hint.__name__}, Real('[0, 1]')]")
    kind = get_origin(hint) or hint
    if kind is Any or not isinstance(kind, type):
        return _Rule("anything", lambda value: value)
    article = "an" if kind.__name__[0] in "AEIOU" else "a"
    return _Rule(f"{article} {kind.__name__}", lambda value: value if isinstance(value, kind) else UNFIT)


def _marked(hint: Any, *marks: Any) -> _Rule:
    for mark in marks:
        if isinstance(mark, Interval):
            return _Rule(mark.words, mark.fit, number=True)
        if isinstance(mark, Choice):
            return _Rule(mark.words, mark.fit, mark.names)
    return rule_of(hint)


def _one_of(names: Iterable[str]) -> str:
    return f"one of {', '.join(names)}"


def _any_of(options: list[_Rule]) -> _Rule:
    def fit(value: Any) -> Any:
        return next((kept for kept in (option.fit(value) for option in options) if kept is not UNFIT), UNFIT)

    choices = tuple(choice for option in options for choice in option.choices)
    words = " or ".join(option.words for option in options)
    return _Rule(words, fit, choices, any(option.number for option in options))


def _tuple_of(hints: tuple[Any, ...]) -> _Rule:
    if hints[-1] is Ellipsis:
        item = rule_of(hints[0])
        words, rules = f"a tuple, each {item.words}", None
    else:
        rules = [rule_of(hint) for hint in hints]
        item = rules[0]
        words = f"a tuple of {len(rules)}, each {item.words}"

    def fit(value: Any) -> Any:
        if not isinstance(value, (tuple, list)) or (rules is not None and len(value) != len(rules)):
            return UNFIT
        kept = tuple(rule.fit(_plain(part)) for rule, part in zip(rules or [item] * len(value), value, strict=True))
        if any(part is UNFIT for part in kept):
            return UNFIT
        same = isinstance(value, tuple) and all(new is old for new, old in zip(kept, value, strict=True))
        return value if same else kept

    return _Rule(words, fit, item.choices, item.number)


def _plain(value: Any) -> Any:
    """A number of numpy's as Python's own. Numpy, which takes long to import, is not imported for it."""
    numpy = sys.modules.get("numpy")
    return value.item() if numpy is not None and isinstance(value, numpy.generic) else value


def without_class(message: str) -> str:
    """An error of a config without the name of its class, which nobody has typed."""
    return re.sub(r"^[A-Z]\w*\.", "", message)


@contextmanager
def as_arguments() -> Iterator[None]:
    """Make a config of a function's own arguments: errors name these, and not the config.

    Raises:
        ConfigError: An argument is not allowed.
    """
    try:
        yield
    except ConfigError as error:
        raise ConfigError(without_class(str(error))) from error


def check_names(called: str, given: Iterable[str], known: Sequence[str]) -> None:
    """Refuse arguments that are not there.

    Args:
        called: Name of what they are given to.
        given: Names of arguments.
        known: Those that there are.

    Raises:
        ConfigError: One is not known; the message names what is like it.
    """
    for name in given:
        if name not in known:
            raise ConfigError(f"{called} has no option {shown(name)}{meant(name, known)}; there are {', '.join(known)}")


def check_argument(name: str, given: Any, hint: Any, words: str | None = None) -> None:
    """Refuse an argument that its annotation does not allow.

    Args:
        name: Name of the argument.
        given: Its value.
        hint: A type, ``Literal`` choices, or a marker in ``Annotated``, as for fields of configs.
        words: What is expected; None: as the annotation says.

    Raises:
        ConfigError: It is not allowed.
    """
    rule = rule_of(hint)
    if rule.fit(_plain(given)) is UNFIT:
        raise ConfigError(f"{name}: expected {words or rule.words}; got {shown(given)}{meant(given, rule.choices)}")


def check_called(name: str, given: Any) -> None:
    """Refuse what cannot be called.

    Raises:
        ConfigError: It cannot.
    """
    if not callable(given):
        raise ConfigError(f"{name}: expected a function or another callable; got {shown(given)}")


def path_of(given: str | os.PathLike[str], name: str = "the path") -> Path:
    """A path that is not empty, for ``Path("")`` would be the current folder.

    Args:
        given: The path.
        name: What it is called in a message.

    Raises:
        ConfigError: It is empty, or no path.
    """
    if not isinstance(given, (str, os.PathLike)):
        raise ConfigError(f"{name}: expected a path; got {shown(given)}")
    if not os.fspath(given):
        raise ConfigError(f"{name} is empty; name a folder or file (. is the current folder)")
    return Path(given)


def is_utf8(path: str | os.PathLike[str]) -> bool:
    """Whether a path is UTF-8. Linux takes any bytes, and libraries in C++ do not."""
    try:
        os.fspath(path).encode()
    except UnicodeEncodeError:
        return False
    return True


def _path(value: Any) -> Any:
    if not isinstance(value, (str, os.PathLike)) or not os.fspath(value):
        return UNFIT
    path = Path(value)
    name = os.fsencode(path)
    fits = b"\0" not in name and len(name) <= LONGEST_PATH
    return path if fits and all(len(part) <= LONGEST_NAME for part in name.split(os.sep.encode())) else UNFIT


def _unit(name: str, rule: _Rule) -> str:
    if rule.number:
        for end, unit in UNITS.items():
            if name == end or name.endswith(f"_{end}"):
                return f" ({unit})"
    return ""
