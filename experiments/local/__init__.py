"""Contingency found within an hour: ranked where it holds, at the table, from images and in real time."""
