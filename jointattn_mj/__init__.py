"""A robot that learns to look where somebody else is looking, from rendered pictures, in MuJoCo."""

from jointattn_mj.scene import gl as _gl

_gl.choose_backend()

__version__ = "0.1.0"
