"""A still camera's video instead of the simulator: perception, attention and the map of faces on real footage."""
