"""Perception, attention and the map of faces on the video of a still camera, in place of the simulator."""
