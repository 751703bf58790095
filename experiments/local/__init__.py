"""Contingency found within an hour of interaction: ranked where it holds, at the table, from images and in real time."""
