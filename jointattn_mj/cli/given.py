"""Options whose defaults follow from another option, such as --preset: the command line says which ones were given.

A config of the package has a value for every option. Here tyro makes a dictionary instead, with the options that were
typed and no others; the config is made afterwards, when it is known which defaults the rest have.
"""

from collections.abc import Mapping
from typing import Annotated, Any, TypedDict, get_args, get_origin

import tyro
from tyro.constructors import MISSING_NONPROP, ConstructorRegistry, StructConstructorSpec, StructTypeInfo

from jointattn_mj.options import Checked


def given_type(kind: type[Checked], defaults: Mapping[str, Checked], without: tuple[str, ...] = ()) -> Any:
    """A type that tyro parses to a dictionary of the options of ``kind`` that were typed, groups as dictionaries.

    Args:
        kind: Class of the config.
        defaults: For help: the config by the choice that it follows from; the first choice is the default.
        without: Fields that are no options here.
    """
    spec = ConstructorRegistry.get_struct_spec(StructTypeInfo.make(kind, MISSING_NONPROP, False))
    assert isinstance(spec, StructConstructorSpec)
    hints: dict[str, Any] = {}
    for field in spec.fields:
        hint, *marks = get_args(field.type) if get_origin(field.type) is Annotated else (field.type,)
        values = {choice: getattr(config, field.name) for choice, config in defaults.items()}
        if field.name in without or any(
            map(_is_config, get_args(hint))
        ):  # a row of configs, or one that may be missing
            continue
        if _is_config(hint):
            hint = given_type(hint, values)
        else:
            text = field.helptext() if callable(field.helptext) else field.helptext
            marks.append(tyro.conf.arg(help=" ".join((text or "").split()), help_behavior_hint=_hint(values)))
        hints[field.name] = Annotated[(hint, *marks)] if marks else hint
    make: Any = TypedDict
    return make(kind.__name__, hints, total=False)


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
