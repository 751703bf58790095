"""Imported before every test: the package chooses an OpenGL backend before anything imports mujoco."""

import os
import signal

import pytest
from shell import Shell

import jointattn_mj  # noqa: F401

os.environ["JOINTATTN_QUIET"] = "1"  # on a slow machine commands would say how far they are
for number in (signal.SIGINT, signal.SIGHUP):
    if signal.getsignal(number) == signal.SIG_IGN:  # of a shell in the background; commands would inherit it
        signal.signal(number, signal.SIG_DFL if number == signal.SIGHUP else signal.default_int_handler)


@pytest.fixture(scope="session")
def jointattn():
    """The command line, in a process that has imported what it needs. It runs where the test is."""
    shell = Shell()
    yield shell
    shell.close()
