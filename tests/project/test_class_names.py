"""Names of the code: no two public classes have one name, and identifiers use the field's words."""

import ast
from collections import Counter

import pytest
from sources import parsed

NOT_OURS = {"one", "she", "her", "hers", "life", "lives", "mind", "minds", "picture", "pictures"}
"""Words for which there is a plainer one: the noun itself, the caregiver, run, agent, image."""


@pytest.fixture(scope="module")
def nodes() -> list[ast.AST]:
    return [node for tree in parsed().values() for node in ast.walk(tree)]


def test_no_two_public_classes_have_one_name(nodes):
    names = Counter(node.name for node in nodes if isinstance(node, ast.ClassDef))
    assert len(names) > 200
    assert [name for name, times in names.items() if times > 1 and not name.startswith("_")] == []


def test_variables_are_called_what_they_hold(nodes):
    names = {node.id for node in nodes if isinstance(node, ast.Name)} | {
        node.arg for node in nodes if isinstance(node, ast.arg)
    }
    assert names & NOT_OURS == set()
