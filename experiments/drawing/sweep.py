"""Sessions of chapter 6 whose images are drawn, or whose bodies are moved, in other ways (sections 6.4.1 and 6.4.3)."""

from dataclasses import replace
from typing import Literal

from jointattn_mj.gaze_following.session import SessionConfig
from jointattn_mj.sweeps.claim import Setting

from ..sessions.sweep import session_config, trial

__all__ = ["FIRST_SEED", "SETTINGS", "VERSION", "trial"]

FIRST_SEED = 1000
"""Sessions with one seed have one caregiver and one robot, whatever draws or moves them."""
VERSION = 2
"""Since 2, a head that has come to rest counts as still where only changes are drawn."""


def drawn(renderer: Literal["opengl", "warp"], draws: Literal["all", "changes"]) -> SessionConfig:
    """The default session with motion cues, from images that are drawn so."""
    config = session_config("pixels", True)
    return replace(config, world=replace(config.world, renderer=renderer, draws=draws))


def moved(dynamics: Literal["mujoco", "closed_form"]) -> SessionConfig:
    """The default session with motion cues, from the state of a world whose bodies move so."""
    config = session_config("state", True)
    return replace(config, world=replace(config.world, dynamics=dynamics))


SETTINGS = {
    "opengl/all": Setting(drawn("opengl", "all"), 40),
    "opengl/changes": Setting(drawn("opengl", "changes"), 40),
    "warp/changes": Setting(drawn("warp", "changes"), 20),
    "state/mujoco": Setting(moved("mujoco"), 20),
    "state/closed_form": Setting(moved("closed_form"), 20),
}
"""What draws, a slash, and what of an image it draws while the head stands still; or state, a slash, and what moves."""
