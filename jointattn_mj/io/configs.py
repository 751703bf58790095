"""Configs from plain data: what ``provenance.write_config`` wrote, read back."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin, get_type_hints

import yaml

from jointattn_mj.errors import ConfigError
from jointattn_mj.options import meant, shown, with_new_choice, with_new_names

Config = TypeVar("Config")


def read_config(path: Path, kind: type[Config]) -> Config:
    """The config in a ``config.yaml`` that a run has left.

    Args:
        path: The file.
        kind: Class of the config, such as ``VariedSessionConfig``. A field that the file does not name has its default.

    Raises:
        ConfigError: The file cannot be read, holds no config of this class, or a value that is not allowed.
    """
    values = values_in(path)
    try:
        return config_of(kind, values)
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from error


def values_in(path: Path) -> Mapping[str, Any]:
    """What a ``config.yaml`` says, as plain data.

    Raises:
        ConfigError: The file cannot be read, or is no ``config.yaml``.
    """
    try:
        content = yaml.safe_load(path.read_text("utf-8"))
        values = content["config"]
    except OSError as error:
        raise ConfigError(f"cannot read {path}: {error.strerror}; give the config.yaml of a run") from error
    except (yaml.YAMLError, UnicodeDecodeError, KeyError, TypeError) as error:
        raise ConfigError(f"{path} is no config.yaml of a run; expected a mapping under the key config") from error
    if not isinstance(values, Mapping):
        raise ConfigError(f"{path} is no config.yaml of a run; expected a mapping under config, got {shown(values)}")
    return values


def config_of(kind: type[Config], values: Mapping[str, Any], location: str = "") -> Config:
    """A config from nested mappings, lists, numbers and texts.

    Args:
        kind: Class of the config.
        values: Values by the names of fields, of today or of the last version; missing ones have their defaults.
        location: Dotted name of the config with a dot at its end, for messages.

    Raises:
        ConfigError: A name that the config does not have, or a value that is not allowed.
    """
    hints = get_type_hints(kind)
    known = [field.name for field in fields(kind)]  # type: ignore[arg-type]
    try:
        values = with_new_names(kind, values, location)
    except TypeError as error:
        raise ConfigError(str(error)) from error
    for name in values:
        if name not in known:
            raise ConfigError(
                f"no option {shown(f'{location}{name}')}{meant(name, known)}; there are {', '.join(known)}"
            )
    made = {name: _value(hints[name], value, f"{location}{name}.") for name, value in values.items()}
    try:
        return kind(**{name: with_new_choice(kind, name, value, location) for name, value in made.items()})
    except ConfigError as error:
        raise ConfigError(str(error).replace(f"{kind.__name__}.", location, 1)) from error


def _value(hint: Any, value: Any, location: str) -> Any:
    """``value`` as a field with this annotation keeps it; what does not fit stays and is refused by the config."""
    origin = get_origin(hint)
    if origin is Annotated:
        return _value(get_args(hint)[0], value, location)
    if origin in (Union, UnionType):
        options = [option for option in get_args(hint) if option is not NoneType]
        return value if value is None or len(options) != 1 else _value(options[0], value, location)
    if origin is tuple and isinstance(value, list):
        parts = get_args(hint)
        every = parts[-1] is Ellipsis or len(parts) != len(value)
        return tuple(_value(parts[0] if every else parts[index], part, location) for index, part in enumerate(value))
    if isinstance(hint, type) and is_dataclass(hint) and isinstance(value, Mapping):
        return config_of(hint, value, location)
    return value
