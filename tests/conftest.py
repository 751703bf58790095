"""Imported before every test: the package chooses an OpenGL backend before anything imports mujoco."""

import os

import jointattn_mj  # noqa: F401

os.environ["JOINTATTN_QUIET"] = "1"  # on a slow machine commands would say how far they are
