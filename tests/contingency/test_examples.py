"""The examples in the docstrings of the measures give what they say, and every public name has one."""

import doctest
import importlib
import inspect

import pytest

from jointattn_mj import contingency, recordings

MODULES = ("measures", "significance", "discovery", "local", "scan", "granger", "series", "situations", "lagged")


@pytest.mark.parametrize("name", MODULES)
def test_examples(name):
    results = doctest.testmod(importlib.import_module(f"jointattn_mj.contingency.{name}"))
    assert results.attempted
    assert not results.failed


def documented():
    """Every public name of the two packages, and the public functions of its classes."""
    for package in (contingency, recordings):
        for name in package.__all__:
            public = getattr(package, name)
            yield public
            yield from (member for key, member in vars(public).items() if inspect.isfunction(member) and key[0] != "_")


@pytest.mark.parametrize("public", documented(), ids=lambda named: named.__qualname__)
def test_every_public_name_is_documented(public):
    words = set(inspect.getdoc(public).split())
    assert "Examples:" in words or (inspect.isclass(public) and "Examples:" in inspect.getsource(public))
    if not inspect.isfunction(public):
        return
    signature = inspect.signature(public)
    given = set(signature.parameters) - {"self"}
    assert "Args:" in words or not given
    assert "Returns:" in words or signature.return_annotation is None
    assert "Raises:" in words or len(given) < 3
