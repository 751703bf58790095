"""A session as a log for Rerun's viewer (rerun.io); it needs the extra ``rerun``."""

from jointattn_mj.adapters.rerun.log import SessionLog

__all__ = ["SessionLog"]
