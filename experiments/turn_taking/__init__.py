"""Constrained turn taking with the three-layered network of the earlier work: a baseline of chapter 6."""
