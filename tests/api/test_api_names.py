"""The names at the top of the package: all there, documented, and imported only when they are asked for."""

import dataclasses
import inspect
import subprocess
import sys
import typing

import pytest

import jointattn_mj

CALLED = [
    "ClaimResult", "Development", "DevelopmentResult", "PerceivedFrame", "PerceptionResult", "Recordings", "Session",
    "SessionResult", "SessionSummary", "Table", "load", "perceive", "read_recordings", "run_claim",
]  # fmt: skip
FULL = ["Development", "Session", "Session.run", "Development.run", "load", "perceive", "read_recordings", "run_claim"]
RESULTS = ["ClaimResult", "DevelopmentResult", "PerceptionResult", "SessionResult"]


def public(name: str):
    """What a name stands for, ``Session.run`` too."""
    value = jointattn_mj
    for part in name.split("."):
        value = getattr(value, part)
    return value


def test_every_name_is_there():
    assert sorted(set(jointattn_mj.__all__)) == sorted(jointattn_mj.__all__)
    assert {name for name in dir(jointattn_mj) if not name.startswith("__")} == {*jointattn_mj.__all__} - {
        "__version__"
    }
    for name in jointattn_mj.__all__:
        assert public(name) is not None
    assert set(CALLED) <= set(jointattn_mj.__all__)
    with pytest.raises(AttributeError, match="has no attribute 'sesion'"):
        jointattn_mj.sesion  # noqa: B018


def test_type_checkers_see_every_name():
    """What stands under TYPE_CHECKING is where the names come from."""
    source = inspect.getsource(jointattn_mj)
    for name, home in jointattn_mj._HOMES.items():
        lines = [line for line in source.splitlines() if line.startswith(f"    from jointattn_mj.{home} import")]
        assert any(name in line.replace(",", " ").split() for line in lines), name


@pytest.mark.parametrize("name", CALLED)
def test_help_says_something(name):
    value = public(name)
    text = inspect.getdoc(value)
    assert text and len(text.splitlines()[0]) > 15
    assert not {"she", "her", "lives", "mind", "picture", "pictures"} & set(text.lower().split())


@pytest.mark.parametrize("name", FULL)
def test_help_has_its_sections(name):
    """Args, Returns (of what returns), Raises, Example; every argument is named."""
    value = public(name)
    text = inspect.getdoc(value)
    sections = ["Args:", "Raises:", "Examples:", *([] if inspect.isclass(value) else ["Returns:"])]
    assert [section for section in sections if section not in text] == []
    for argument in inspect.signature(value).parameters:
        if argument != "self":
            assert f"{argument}:" in text, argument


@pytest.mark.parametrize("name", [name for name in CALLED if inspect.isclass(public(name))])
def test_help_of_methods_has_its_sections(name):
    """Those of the class and of the package's classes that it derives from."""
    kind = public(name)
    for member in (member for member in dir(kind) if not member.startswith("_")):
        method = getattr(kind, member)
        if not callable(method) or not method.__module__.startswith("jointattn_mj"):
            continue
        text, signature = inspect.getdoc(method), inspect.signature(method)
        assert text and "Examples:" in text, member
        assert "Returns:" in text or signature.return_annotation is None, member
        given = [argument for argument in signature.parameters if argument != "self"]
        assert not given or ("Args:" in text and "Raises:" in text), member
        assert all(f"{argument}:" in text for argument in given), member


@pytest.mark.parametrize("name", RESULTS)
def test_results_open_from_a_folder(name):
    kind = public(name)
    assert "Examples:" in inspect.getdoc(kind)
    text = inspect.getdoc(kind.open)
    assert "Args:" in text and "Raises:" in text and "folder" in inspect.signature(kind.open).parameters
    for member, value in inspect.getmembers_static(kind):
        if not member.startswith("_") and isinstance(value, property):
            assert value.fget.__annotations__["return"] is not None and value.__doc__, member


def test_arguments_are_named_like_options():
    from jointattn_mj.api.perceive import PerceiveFields
    from jointattn_mj.api.session import LoggedSessionOptions
    from jointattn_mj.cli.experiment import ExperimentRunOptions
    from jointattn_mj.footage.config import PerceiveConfig, PerceiveOptions

    def arguments(call, *left_out: str) -> set[str]:
        return set(inspect.signature(call).parameters) - {"self", *left_out}

    def options(kind) -> set[str]:
        return {field.name for field in dataclasses.fields(kind)}

    assert arguments(jointattn_mj.Session.run, "progress", "kind") == options(LoggedSessionOptions)
    assert arguments(jointattn_mj.perceive, "video", "options", "progress") == options(PerceiveOptions)
    assert set(typing.get_type_hints(PerceiveFields)) | {"video"} == options(PerceiveConfig) | {"motion_cues"}
    assert arguments(jointattn_mj.run_claim, "claim", "watcher") | {"claims"} == options(ExperimentRunOptions)


LIGHT = """
import sys
import jointattn_mj
dir(jointattn_mj), jointattn_mj.__version__
heavy = ("numpy", "mujoco", "dm_control", "torch", "cv2", "numba", "scipy", "matplotlib", "pyarrow", "tyro", "yaml")
print(*(name for name in heavy if name in sys.modules))
jointattn_mj.contingency
print(*(name for name in ("mujoco", "cv2", "torch", "matplotlib", "jointattn_mj.recordings") if name in sys.modules))
from jointattn_mj import *
print(Session.__name__, load.__name__)
"""


@pytest.mark.integration
def test_nothing_is_imported_before_it_is_asked_for():
    done = subprocess.run([sys.executable, "-c", LIGHT], capture_output=True, text=True)
    assert done.stderr == ""
    assert done.stdout == "\n\nSession load\n"


def test_read_recordings_by_its_old_name():
    from jointattn_mj import contingency

    with pytest.warns(DeprecationWarning, match=r"now called jointattn_mj\.read_recordings"):
        assert contingency.read_recordings is jointattn_mj.read_recordings
    with pytest.raises(AttributeError):
        contingency.nothing  # noqa: B018
