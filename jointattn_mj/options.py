"""Marks on config fields that the command line reads; to everybody else they are comments."""

import tyro

TOP_LEVEL = tyro.conf.arg(prefix_name=False)
"""An option that many use: `--caregiver`, not `--world.scene.caregiver`."""
