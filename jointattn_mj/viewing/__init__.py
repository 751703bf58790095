"""An agent in a task, live: in a window where there is a display, else in a browser; and as a video."""
