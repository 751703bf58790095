"""The robot of chapter 6 at a video of a table, in place of the rendered world."""
