"""The laboratory: claims of the dissertation as experiments that can be run, stopped, resumed, enlarged and read."""
