"""Public functions with three or more arguments say in an Args section what each is."""

import ast
import re
from collections.abc import Iterator

from sources import ROOT, parsed

FUNCTION = ast.FunctionDef | ast.AsyncFunctionDef
ELSEWHERE = re.compile(r"\bsee(\s+:\w+:|\s)`|\barguments\b[^.]*\b(of|see)\b", re.IGNORECASE)
"""A docstring that names where the arguments are described, as that of a method of a protocol does."""


def public_functions(node: ast.AST) -> Iterator[FUNCTION]:
    """Functions and methods that are called from elsewhere: not those within functions or of private classes."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, FUNCTION):
            if not child.name.startswith("_") and "overload" not in map(ast.unparse, child.decorator_list):
                yield child
        elif not (isinstance(child, ast.ClassDef) and child.name.startswith("_")):
            yield from public_functions(child)


def arguments(function: FUNCTION) -> list[str]:
    """Names of the arguments, but for those that a command takes as its options."""
    given = (*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs)
    options = [each for each in given if each.annotation is not None and "FLAT]" in ast.unparse(each.annotation)]
    return [each.arg for each in given if each.arg not in ("self", "cls") and each not in options]


def not_described(function: FUNCTION) -> list[str]:
    """Arguments that no Args section names, of a function that has three or more."""
    names, text = arguments(function), ast.get_docstring(function) or ""
    if len(names) < 3 or ("Args:" not in text and ELSEWHERE.search(text)):
        return []
    section = text.partition("Args:")[2]
    return [
        name for name in names if not re.search(rf"^ +([\w*]+, )*\*{{0,2}}{name}(, [\w*]+)*:", section, re.MULTILINE)
    ]


def test_arguments_are_described():
    functions = [(path, function) for path, tree in parsed().items() for function in public_functions(tree)]
    assert sum(len(arguments(function)) >= 3 for _, function in functions) > 300
    assert [
        f"{path.relative_to(ROOT)}: {function.name} does not say what {', '.join(missing)} is"
        for path, function in functions
        if (missing := not_described(function))
    ] == []


def test_a_function_without_a_section_is_found():
    (function,) = ast.parse(
        'def f(a, b, c):\n    """Add.\n\n    Args:\n        a: One.\n        c: Three.\n    """'
    ).body
    assert not_described(function) == ["b"]
