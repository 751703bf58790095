"""Imported before every test: the package chooses an OpenGL backend before anything imports mujoco."""

import jointattn_mj  # noqa: F401
