"""The examples in the docstrings of the measures give what they say, and every public name has one."""

import doctest
import importlib
import inspect

import pytest

from jointattn_mj import contingency

MODULES = ("measures", "significance", "discovery", "local", "scan", "granger", "series", "situations")


@pytest.mark.parametrize("name", MODULES)
def test_examples(name):
    results = doctest.testmod(importlib.import_module(f"jointattn_mj.contingency.{name}"))
    assert results.attempted
    assert not results.failed


@pytest.mark.parametrize("name", [name for name in contingency.__all__ if name.islower() and "recordings" not in name])
def test_every_function_is_documented(name):
    function = getattr(contingency, name)
    assert "Examples:" in function.__doc__
    if len(inspect.signature(function).parameters) > 2:
        assert {"Args:", "Returns:", "Raises:"} <= set(function.__doc__.split())
