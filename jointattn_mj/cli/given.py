"""Options whose defaults follow from another option, such as --preset: tyro hands on those that were typed, no others.

A config of the package has a value for every option. Of a parameter whose default is ``typed_only`` tyro makes a
dictionary of the options that were typed, groups as dictionaries; the config is made of it, when all of them are known.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, TypedDict, TypeVar, get_args, get_origin

import tyro
from tyro.constructors import (
    MISSING_NONPROP,
    ConstructorRegistry,
    PrimitiveConstructorSpec,
    PrimitiveTypeInfo,
    StructConstructorSpec,
    StructFieldSpec,
    StructTypeInfo,
)

from jointattn_mj.options import Checked, path_of

Config = TypeVar("Config", bound=Checked)
GIVEN = ConstructorRegistry()
"""Has to be entered around tyro's work."""


def typed_only(default: Config, variants: Mapping[str, Checked], make: Callable[..., Any] = dict) -> Config:
    """``default``, as default of a parameter of which only typed options are handed on.

    Args:
        default: The config, for its class.
        variants: For help: the config by the option that it follows from; the first one holds where none is typed.
        make: Called with the options that were typed.
    """
    group = _Group(default, variants, make)
    own: Config = group.default
    _GROUPS[id(own)] = group
    return own


class _Group:
    """A config of which only typed options are handed on."""

    def __init__(self, default: Any, variants: Mapping[str, Checked], make: Callable[..., Any]):
        self.default = replace(default)  # an object of its own, by whose id tyro's rule finds the group
        self._variants, self._make = variants, make

    @cached_property
    def spec(self) -> StructConstructorSpec:
        """What tyro parses."""
        whole = ConstructorRegistry.get_struct_spec(StructTypeInfo.make(type(self.default), MISSING_NONPROP, False))
        assert isinstance(whole, StructConstructorSpec)
        return StructConstructorSpec(
            self._make, tuple(self._field(field) for field in whole.fields if _is_option(field))
        )

    def _field(self, field: StructFieldSpec) -> StructFieldSpec:
        hint, marks = _parts(field.type)
        values = {choice: getattr(config, field.name) for choice, config in self._variants.items()}
        if _is_config(hint):
            return replace(field, default=typed_only(getattr(self.default, field.name), values))
        told: Any = Annotated[(hint, *marks, tyro.conf.arg(help_behavior_hint=_hint(values)))]
        return replace(_untyped(field.name, told), helptext=field.helptext)


_GROUPS: dict[int, _Group] = {}


@GIVEN.struct_rule
def _rule(info: StructTypeInfo) -> StructConstructorSpec | None:
    group = _GROUPS.get(id(info.default))
    return None if group is None else group.spec


@GIVEN.primitive_rule
def _path_rule(info: PrimitiveTypeInfo) -> PrimitiveConstructorSpec[Path] | None:
    """Paths that may not be empty: ``Path("")`` is the current folder."""
    if info.type is not Path:
        return None
    return PrimitiveConstructorSpec(
        nargs=1,
        metavar="PATH",
        instance_from_str=lambda texts: path_of(texts[0]),
        is_instance=lambda value: isinstance(value, Path),
        str_from_instance=lambda path: [str(path)],
    )


def _untyped(name: str, hint: Any) -> StructFieldSpec:
    """A field that is left out where it is not typed, as tyro has it in dictionaries of which no key is required."""
    make: Any = TypedDict
    spec = ConstructorRegistry.get_struct_spec(
        StructTypeInfo.make(make("Options", {name: hint}, total=False), MISSING_NONPROP, False)
    )
    assert isinstance(spec, StructConstructorSpec)
    return spec.fields[0]


def _parts(annotation: Any) -> tuple[Any, tuple[Any, ...]]:
    """An annotation without its marks, and these."""
    hint, *marks = get_args(annotation) if get_origin(annotation) is Annotated else (annotation,)
    return hint, tuple(marks)


def _is_option(field: StructFieldSpec) -> bool:
    """Whether there is a choice that can be typed: several values, and no row of configs, nor a config or None."""
    hint, _ = _parts(field.type)
    fixed = get_origin(hint) is Literal and len(get_args(hint)) == 1
    return not fixed and not any(map(_is_config, get_args(hint)))


def _is_config(hint: Any) -> bool:
    return isinstance(hint, type) and issubclass(hint, Checked)


def _hint(values: Mapping[str, Any]) -> str:
    """The default, and which choices have another: ``(default: 3; 9 with chapter4)``."""
    by_text: dict[str, list[str]] = {}
    for choice, value in values.items():
        text = " ".join(map(str, value)) if isinstance(value, tuple) else str(value)
        if text != choice or not by_text:  # --preset itself has every choice as its value
            by_text.setdefault(text or "none", []).append(choice)
    (first, _), *others = by_text.items()
    said = [first, *(f"{text} with {', '.join(choices)}" for text, choices in others)]
    return f"(default: {'; '.join(said)})"
