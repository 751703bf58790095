"""A session as a log for Rerun's viewer (rerun.io). Needs the extra ``rerun``; nothing else imports this."""

from jointattn_mj.adapters.rerun.log import SessionLog

__all__ = ["SessionLog"]
