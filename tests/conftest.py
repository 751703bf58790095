"""Imported before every test: the package chooses an OpenGL backend before anything imports mujoco."""

import os
import re
import signal

import pytest
from shell import Shell

import jointattn_mj  # noqa: F401

os.environ["JOINTATTN_QUIET"] = "1"  # on a slow machine commands would say how far they are
for number in (signal.SIGINT, signal.SIGHUP):
    if signal.getsignal(number) == signal.SIG_IGN:  # of a shell in the background; commands would inherit it
        signal.signal(number, signal.SIG_DFL if number == signal.SIGHUP else signal.default_int_handler)


INTEGRATION = re.compile(r"^pytestmark = pytest\.mark\.integration$", re.MULTILINE)


def pytest_ignore_collect(collection_path, config):
    """Leave out, without importing them, files of integration tests alone where those are not asked for: to collect the
    others takes 8 s of the processor in place of 14, in each process."""
    if collection_path.suffix == ".py" and "not integration" in config.option.markexpr:
        return True if INTEGRATION.search(collection_path.read_text("utf-8")) else None
    return None


@pytest.hookimpl(tryfirst=True)  # before tests are chosen by their marks
def pytest_collection_modifyitems(items):
    """Whatever runs the command line is an integration test."""
    for item in items:
        if "jointattn" in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.integration)


@pytest.fixture(scope="session")
def jointattn():
    """The command line, in a process that has imported what it needs. It runs where the test is."""
    shell = Shell()
    yield shell
    shell.close()
