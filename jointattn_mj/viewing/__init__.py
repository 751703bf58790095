"""An agent in a task, seen live: in a window where there is a display, else in a browser."""
