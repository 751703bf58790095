"""Objects as plain data and back: no pickle, no constructor is called, and nothing is looked up but listed classes.

A state becomes a list of entries, ``[kind, ...]``, and arrays. Values in an entry are null, booleans, integers, floats
and texts as they are, ``{"float": "nan"}``, or ``[n]``, which is entry n; the first entry is the state itself. So what
was one object in two places is one object again; arrays that share memory without being one object become two, as by
``copy.deepcopy``. Parts of the config that the caller gives are not written: an entry says where in it they are.
"""

import math
from base64 import b64decode, b64encode
from collections import OrderedDict, defaultdict, deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import Path, PosixPath, WindowsPath
from typing import Any

import numpy as np

from jointattn_mj.io.archive import aligned
from jointattn_mj.io.parts import PACKAGE, PARTS, class_named, is_own, may_set, name_of

Entry = list[Any]
_FACTORIES = {kind.__name__: kind for kind in (list, dict, set, int, float)}
_GENERATORS = ("PCG64", "PCG64DXSM", "SFC64")
"""Those of numpy's whose state is numbers alone: none of them is a place in memory."""
_NUMBERS = "biufcSU"
_LONGEST_KEY = 64
_LARGEST_POOL = 64
_LARGEST_SIZE = 10**7
"""A run has some thousands. Lists of the same list, level upon level, have any number: to write or compare such a
value, if only for an error message, would never end."""
_LARGEST_NUMBER = 1e100
"""No run of this package comes near it, and its square is still a number: larger ones were put there by hand."""


class Encoder:
    """Takes in a state; ``entries`` and ``arrays`` are then what has to be written."""

    def __init__(self, config: Any, own: str):
        """``config``: what need not be written; ``own``: a module whose classes may be met."""
        self.entries: list[Entry] = []
        self.arrays: list[np.ndarray] = []
        self._own = own
        self._parts = list(_parts(config))
        self._numbers: dict[int, int] = {}
        self._alive: list[Any] = []  # an id is that of an object only as long as it lives

    def value(self, value: Any) -> Any:
        """``value`` as it stands in an entry.

        Raises:
            TypeError: It, or something in it, has no place in a checkpoint.
        """
        kind = type(value)
        if value is None or kind in (bool, int, str):
            return value
        if kind is float:
            return value if math.isfinite(value) else {"float": repr(value)}
        if id(value) not in self._numbers:
            number = self._numbers[id(value)] = len(self.entries)
            self._alive.append(value)
            self.entries.append([])
            self.entries[number] = self._entry(kind, value)
        return [self._numbers[id(value)]]

    def _entry(self, kind: type, value: Any) -> Entry:
        if is_dataclass(kind):
            location = next((location for location, part in self._parts if type(part) is kind and part == value), None)
            if location is not None:
                return ["config", *location]
        if kind in _WRITERS:
            return _WRITERS[kind](self, value)
        if isinstance(value, np.ndarray):
            self.arrays.append(value)
            return ["array", len(self.arrays) - 1, *(["aligned"] if value.dtype.isalignedstruct else [])]
        if isinstance(value, np.generic) and value.dtype.kind in _NUMBERS:
            return ["scalar", value.dtype.str, value.tobytes().hex()]
        name = name_of(kind, self._own)
        if isinstance(value, Enum):
            return ["enum", name, value.name]
        if _is_named_tuple(kind):
            return ["named", name, *map(self.value, value)]
        return self._object(kind, name, value)

    def _object(self, kind: type, name: str, value: Any) -> Entry:
        object.__new__(kind)  # what cannot be made without its constructor cannot be restored
        if hasattr(kind, "__setstate__"):
            state = value.__getstate__()
            _check_state(kind, state, self._own)
            return ["state", name, self.value(state)]
        attributes = value.__getstate__() or {}
        if not isinstance(attributes, dict) or (is_dataclass(kind) and attributes.keys() != _names(kind)):
            raise TypeError(f"{name} needs __getstate__ and __setstate__ to be kept in a checkpoint")
        _check_names(kind, attributes)
        return ["object", name, *self._flat(attributes)]

    def _flat(self, mapping: dict[Any, Any]) -> Entry:
        return [self.value(part) for key, value in mapping.items() for part in (_key(key), value)]

    def _sorted(self, values: Iterable[Any]) -> Entry:
        return [
            self.value(_key(value))
            for value in sorted(values, key=lambda member: (type(member).__name__, repr(member)))
        ]

    def _generator(self, generator: np.random.Generator) -> Entry:
        bits = generator.bit_generator
        name = type(bits).__name__
        if name not in _GENERATORS:
            raise TypeError(f"random numbers of {name} cannot be kept in a checkpoint; use {' or '.join(_GENERATORS)}")
        return ["generator", name, self.value(bits.state), self.value(bits.seed_seq)]

    def _seeds(self, seeds: np.random.SeedSequence) -> Entry:
        entropy = list(seeds.entropy) if isinstance(seeds.entropy, Sequence) else seeds.entropy
        parts = entropy, list(seeds.spawn_key), seeds.pool_size, seeds.n_children_spawned
        return ["seeds", *(self.value(part) for part in parts)]


_WRITERS: dict[type, Callable[[Encoder, Any], Entry]] = {
    list: lambda to, value: ["list", *map(to.value, value)],
    tuple: lambda to, value: ["tuple", *map(to.value, value)],
    set: lambda to, value: ["set", *to._sorted(value)],
    frozenset: lambda to, value: ["frozenset", *to._sorted(value)],
    dict: lambda to, value: ["dict", *to._flat(value)],
    OrderedDict: lambda to, value: ["ordered", *to._flat(value)],
    defaultdict: lambda to, value: ["default", _factory(value), *to._flat(value)],
    deque: lambda to, value: ["deque", value.maxlen, *map(to.value, value)],
    bytes: lambda to, value: ["bytes", b64encode(value).decode()],
    bytearray: lambda to, value: ["bytearray", b64encode(value).decode()],
    complex: lambda to, value: ["complex", to.value(value.real), to.value(value.imag)],
    slice: lambda to, value: ["slice", to.value(value.start), to.value(value.stop), to.value(value.step)],
    range: lambda to, value: ["range", value.start, value.stop, value.step],
    PosixPath: lambda to, value: ["path", str(value)],
    WindowsPath: lambda to, value: ["path", str(value)],
    np.random.Generator: lambda to, value: to._generator(value),
    np.random.SeedSequence: lambda to, value: to._seeds(value),
}


class Decoder:
    """Makes of entries what they stand for."""

    def __init__(self, entries: list[Entry], array: Callable[[int], np.ndarray], config: Any, own: str):
        """``array`` reads the array of a number; ``config`` and ``own`` as for ``Encoder``."""
        self._entries, self._array, self._own = entries, array, own
        self._config = {location: part for location, part in _parts(config)}
        self._made: dict[int, Any] = {}
        self._begun: set[int] = set()
        self._sizes: dict[int, int] = {}

    def value(self, value: Any) -> Any:
        """What a value of an entry stands for.

        Raises:
            Exception: Of many kinds, since restored classes check what they are given; it is no such value.
        """
        if value is None or type(value) in (bool, int, float, str):
            if type(value) is float:
                self._check_size(value)
            return value
        if isinstance(value, dict) and value.get("float") in ("nan", "inf", "-inf"):
            return float(value["float"])
        if isinstance(value, list) and len(value) == 1 and type(value[0]) is int:
            return self._numbered(value[0])
        raise ValueError(f"{value!r:.80} is no value")

    def _check_size(self, numbers: float | np.ndarray) -> None:
        if self._own.partition(".")[0] in ("", PACKAGE):
            size = np.abs(numbers)
            if np.any(np.isfinite(size) & (size > _LARGEST_NUMBER)):
                raise ValueError(f"a number in it is beyond {_LARGEST_NUMBER:g}")

    def _numbered(self, number: int) -> Any:
        if number in self._made:
            return self._made[number]
        if number in self._begun or not 0 <= number < len(self._entries):
            raise ValueError(f"entry {number} is missing, or a part of itself")
        self._begun.add(number)
        kind, *rest = self._entries[number]
        made = _READERS[kind](self, number, *rest)
        self._sizes[number] = 1 + sum(map(self._size, rest))
        if self._sizes[number] > _LARGEST_SIZE:
            raise ValueError(f"entry {number} unfolds to more than {_LARGEST_SIZE:,} values")
        return self._made.setdefault(number, made)

    def _size(self, value: Any) -> int:
        """How many values one of an entry is, where what stands in several places is counted in each."""
        refers = isinstance(value, list) and len(value) == 1 and type(value[0]) is int
        return self._sizes.get(value[0], 1) if refers else 1

    def _values(self, values: Iterable[Any]) -> Iterable[Any]:
        return (self.value(value) for value in values)

    def _fill(self, number: int, container: Any, values: Sequence[Any]) -> Any:
        """A container that may hold itself."""
        self._made[number] = container
        container.extend(self._values(values))
        return container

    def _map(self, number: int, mapping: Any, flat: Sequence[Any]) -> Any:
        self._made[number] = mapping
        for key, value in zip(flat[::2], flat[1::2], strict=True):
            mapping[_key(self.value(key))] = self.value(value)
        return mapping

    def _array_of(self, number: int, index: int, flag: str = "") -> np.ndarray:
        array = self._array(index)
        if array.dtype.kind == "f" and array.itemsize >= 8:
            self._check_size(array)
        return array.view(aligned(array.dtype)) if flag == "aligned" else array

    def _enum(self, number: int, name: str, member: str) -> Enum:
        kind = class_named(name, self._own)
        if not issubclass(kind, Enum):
            raise ValueError(f"{name} is no enumeration")
        return kind.__members__[member]

    def _named(self, number: int, name: str, *values: Any) -> tuple[Any, ...]:
        kind = class_named(name, self._own)
        if not _is_named_tuple(kind) or len(values) != len(kind._fields):  # type: ignore[attr-defined]
            raise ValueError(f"{name} has other fields")
        made: tuple[Any, ...] = tuple.__new__(kind, self._values(values))
        return made

    def _object(self, number: int, name: str, *flat: Any) -> Any:
        kind = class_named(name, self._own)
        if hasattr(kind, "__setstate__") or issubclass(kind, Enum):
            raise ValueError(f"{name} is not made of attributes")
        made: Any = object.__new__(kind)
        self._made[number] = made
        attributes = dict(zip(flat[::2], self._values(flat[1::2]), strict=True))
        if is_dataclass(kind) and attributes.keys() != _names(kind):
            raise ValueError(f"{name} has other fields")
        _check_names(kind, attributes)
        for attribute, value in attributes.items():
            object.__setattr__(made, attribute, value)
        if name in PARTS and is_dataclass(kind) and hasattr(kind, "__post_init__"):
            kind.__post_init__(made)  # the bounds of its numbers
        return made

    def _state(self, number: int, name: str, state: Any) -> Any:
        kind = class_named(name, self._own)
        made: Any = object.__new__(kind)
        self._made[number] = made
        given = self.value(state)
        _check_state(kind, given, self._own)
        kind.__setstate__(made, given)  # type: ignore[attr-defined]
        return made

    def _generator(self, number: int, name: str, state: Any, seeds: Any) -> np.random.Generator:
        given, seed_seq = self.value(state), self.value(seeds)
        if name not in _GENERATORS or not isinstance(seed_seq, np.random.SeedSequence):
            raise ValueError(f"{name} is no generator of random numbers that is known")
        bits = getattr(np.random, name)(seed_seq)
        bits.state = given
        return np.random.Generator(bits)

    def _seeds(self, number: int, entropy: Any, key: Any, pool: int, children: int) -> np.random.SeedSequence:
        if not 4 <= pool <= _LARGEST_POOL:
            raise ValueError(f"a pool of {pool} is none of a SeedSequence")
        return np.random.SeedSequence(
            self.value(entropy), spawn_key=self.value(key), pool_size=pool, n_children_spawned=children
        )


def _scalar(text: str, content: str) -> np.generic:
    dtype = np.dtype(text)
    if dtype.kind not in _NUMBERS:
        raise ValueError(f"{text} is no dtype of numbers")
    (value,) = np.frombuffer(bytes.fromhex(content), dtype)
    scalar: np.generic = value
    return scalar


_READERS: dict[str, Callable[..., Any]] = {
    "config": lambda of, number, *location: of._config[location],
    "array": Decoder._array_of,
    "scalar": lambda of, number, dtype, content: _scalar(dtype, content),
    "enum": Decoder._enum,
    "named": Decoder._named,
    "object": Decoder._object,
    "state": Decoder._state,
    "list": lambda of, number, *values: of._fill(number, [], values),
    "tuple": lambda of, number, *values: tuple(of._values(values)),
    "set": lambda of, number, *values: set(map(_key, of._values(values))),
    "frozenset": lambda of, number, *values: frozenset(map(_key, of._values(values))),
    "dict": lambda of, number, *flat: of._map(number, {}, flat),
    "ordered": lambda of, number, *flat: of._map(number, OrderedDict(), flat),
    "default": lambda of, number, name, *flat: of._map(number, defaultdict(_FACTORIES[name]), flat),
    "deque": lambda of, number, most, *values: of._fill(number, deque(maxlen=most), values),
    "bytes": lambda of, number, text: b64decode(text, validate=True),
    "bytearray": lambda of, number, text: bytearray(b64decode(text, validate=True)),
    "complex": lambda of, number, real, imaginary: complex(of.value(real), of.value(imaginary)),
    "slice": lambda of, number, *ends: slice(*of._values(ends)),
    "range": lambda of, number, *ends: range(*of._values(ends)),
    "path": lambda of, number, text: Path(text),
    "generator": Decoder._generator,
    "seeds": Decoder._seeds,
}


def _parts(config: Any, location: tuple[Any, ...] = ()) -> Iterable[tuple[tuple[Any, ...], Any]]:
    """Every dataclass in a config, and the names of fields and positions that lead to it."""
    if is_dataclass(config) and not isinstance(config, type):
        yield location, config
        for field in fields(config):
            yield from _parts(getattr(config, field.name), (*location, field.name))
    elif isinstance(config, tuple):
        for position, item in enumerate(config):
            yield from _parts(item, (*location, position))


def _key(value: Any) -> Any:
    """A key of a mapping or set, if it is found in no time: a plain value, or a short tuple of such."""
    plain = (str, int, float, complex, bytes, Path, Enum, np.generic, type(None))
    if isinstance(value, plain) or (
        isinstance(value, tuple) and len(value) <= _LONGEST_KEY and all(isinstance(item, plain) for item in value)
    ):
        return value
    raise TypeError(f"a {type(value).__name__} cannot be a key in a checkpoint")


def _factory(mapping: defaultdict[Any, Any]) -> str:
    for name, kind in _FACTORIES.items():
        if mapping.default_factory is kind:
            return name
    raise TypeError(f"a defaultdict of {mapping.default_factory} cannot be kept in a checkpoint")


def _names(kind: type) -> set[str]:
    return {field.name for field in fields(kind)}


def _check_names(kind: type, attributes: Iterable[Any]) -> None:
    for name in attributes:
        if not may_set(kind, name):
            raise ValueError(f"{name!r:.80} cannot be an attribute of {kind.__qualname__}")


def _check_state(kind: type, state: Any, own: str) -> None:
    """What a class of ours gives to its ``__setstate__`` are its attributes; one of the caller's knows what it does."""
    if isinstance(state, dict) and not is_own(kind, "__setstate__", own):
        _check_names(kind, state)


def _is_named_tuple(kind: type) -> bool:
    return issubclass(kind, tuple) and isinstance(getattr(kind, "_fields", None), tuple)
