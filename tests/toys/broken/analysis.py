"""Fails."""


def analyse(trials):
    """Not this time."""
    raise KeyError("missing")


def draw(trials):
    """Nothing to see."""
    return {}
