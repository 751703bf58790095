"""Constrained turn taking: the interaction of the earlier work (reference [19] of the dissertation), a baseline."""
