"""A session before a person, live on a page of this machine: what the robot sees, attends to and knows."""

from jointattn_mj.viewing.live.view import LiveView

__all__ = ["LiveView"]
