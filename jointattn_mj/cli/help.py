"""Help in two lengths: ``--help`` has what people set, ``--help-all`` everything, what few people set last.

What people set are the options without a dot: those of the command's own configs, and those marked ``TOP_LEVEL`` in
nested ones, without those that a config calls ``ADVANCED``. Every option is accepted, whatever help shows.
"""

import inspect
import io
import re
import shutil
import textwrap
from collections.abc import Callable, Iterator, Sequence
from contextlib import redirect_stderr, redirect_stdout, suppress
from dataclasses import is_dataclass, replace
from itertools import takewhile
from typing import Annotated, Any, get_args, get_type_hints

import tyro
from tyro.constructors import ConstructorRegistry, StructConstructorSpec, StructFieldSpec, StructTypeInfo

from jointattn_mj.cli.usage import complaint
from jointattn_mj.errors import ConfigError
from jointattn_mj.options import TOP_LEVEL, Checked

Choose = Callable[[type[Checked], str, Any], bool]
"""Whether a field is shown, from its class, its name and its annotation."""
ALL = "--help-all"
HELP = ("-h", "--help", ALL)
ADVANCED = "advanced: what few people ever set"


def help_text(command: Callable[..., Any], prog: str, arguments: Sequence[str]) -> str:
    """Help of a command.

    Args:
        command: Its annotations say which options there are.
        prog: What stands before the options.
        arguments: Words of the command line; with --help-all among them everything is shown.

    Raises:
        ConfigError: They name no sub-command.
    """
    words = [*takewhile(lambda word: not word.startswith("-"), arguments), "--help"]  # sub-commands, no options
    own = set(configs_of(command))
    more = []
    if "config" in get_type_hints(command):
        more.append("--config FILE takes defaults from the config.yaml of an earlier run; options override them.")
    if ALL in arguments:
        text = _text(command, prog, words, lambda kind, name, hint: not _is_advanced(kind, name))
        tuned = _text(command, prog, words, lambda kind, name, hint: _is_advanced(kind, name))
        groups = [_without_help(part) for part in tuned.split("\n\n ") if re.match(r"(.+ )?options\n", part)]
        groups = [group for group in groups if "\n  --" in group]
        more = [ADVANCED, "", *(f" {group}\n" for group in groups), *more] if groups else more
    else:
        text = _text(
            command,
            prog,
            words,
            lambda kind, name, hint: (kind in own and not _is_advanced(kind, name)) or TOP_LEVEL in get_args(hint),
        )
        text = re.sub(r"\n\n \S+ options\n(?:  [^ -].*\n)*(?=  -)", "\n", text)  # all in one group
        if any(_is_nested(hint) for kind in own for hint in get_type_hints(kind).values()):
            more.append(f"{ALL} lists the options of all parts too.")
        elif any(base.__dict__.get("ADVANCED") for kind in own for base in kind.__mro__):
            more.append(f"{ALL} lists the options that few people set too.")
    return "\n".join([text, "", *more]) if more else text


def _without_help(group: str) -> str:
    """A group of options without --help, which stands among a command's own."""
    return re.sub(r"^  -h, --help\b.*\n(?: {4,}.*\n)*", "", group, flags=re.M)


def configs_of(command: Callable[..., Any]) -> Iterator[type[Checked]]:
    """Classes of configs in the annotations of a command's parameters."""
    todo = list(get_type_hints(command, include_extras=True).values())
    while todo:
        hint = todo.pop()
        if isinstance(hint, type) and issubclass(hint, Checked):
            yield hint
        todo += get_args(hint)


def _is_advanced(kind: type[Checked], name: str) -> bool:
    """Whether a config, or one that it derives from, calls an option advanced."""
    return any(name in base.__dict__.get("ADVANCED", ()) for base in kind.__mro__)


def _is_nested(hint: Any) -> bool:
    return isinstance(hint, type) and is_dataclass(hint)


def _text(command: Callable[..., Any], prog: str, arguments: Sequence[str], choose: Choose) -> str:
    """What tyro says with the fields that are chosen, as plain text."""
    registry, said, trouble = ConstructorRegistry(), io.StringIO(), io.StringIO()
    asking = False

    @registry.struct_rule
    def chosen(info: StructTypeInfo) -> StructConstructorSpec | None:
        nonlocal asking
        kind: Any = info.type
        if asking or not (isinstance(kind, type) and issubclass(kind, Checked)):
            return None
        asking = True
        try:
            whole = ConstructorRegistry.get_struct_spec(info)
        finally:
            asking = False
        if not isinstance(whole, StructConstructorSpec):
            return None
        fields = [_as_shown(field) for field in whole.fields if shown(kind, field)]
        return replace(whole, fields=tuple(sorted(fields, key=_may_be_left_out)))

    def shown(kind: type[Checked], field: StructFieldSpec) -> bool:
        hint: Any = field.type
        return _is_nested(hint) or choose(kind, field.name, hint)

    with redirect_stdout(said), redirect_stderr(trouble), suppress(SystemExit):
        tyro.cli(
            command,
            prog=prog,
            description=_about(command),
            args=list(arguments),
            registry=registry,
            config=(tyro.conf.DisallowNone,),
        )
    if trouble.getvalue():
        raise ConfigError(complaint(trouble.getvalue()))
    lines = [line.rstrip() for line in said.getvalue().splitlines() if not re.fullmatch(r" *-{9,} *", line)]
    width = shutil.get_terminal_size().columns
    text = "\n".join(
        textwrap.fill(line, width, break_on_hyphens=False) if len(line) > width else line for line in lines
    ).strip()
    return re.sub(r"\n{3,}", "\n\n", text)


def _about(command: Callable[..., Any]) -> str:
    """The docstring of a command, each paragraph on one line; lists stay as they are."""
    paragraphs = (inspect.getdoc(command) or "").split("\n\n")
    text = "\n\n".join(part if part.startswith("* ") else " ".join(part.split()) for part in paragraphs)
    return text.replace("``", "")


def _as_shown(field: StructFieldSpec) -> StructFieldSpec:
    """A field with its help on one line, which the terminal's width alone breaks; a flag that is off has one form."""
    whole: Any = field.helptext
    said = whole() if callable(whole) else whole
    hint: Any = Annotated[field.type, tyro.conf.FlagCreatePairsOff] if field.default is False else field.type
    return replace(field, type=hint, helptext=" ".join(said.replace("``", "").split()) if said else None)


def _may_be_left_out(field: StructFieldSpec) -> bool:
    """False for what is required, and listed first."""
    return field.default not in (tyro.MISSING, tyro.MISSING_NONPROP)
