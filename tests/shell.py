"""Command lines for tests; see ``tools.shell``."""

from tools.shell import Outcome, Shell

__all__ = ["Outcome", "Shell"]
