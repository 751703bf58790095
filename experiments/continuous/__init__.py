"""Gaze following that becomes continuous once it is found (section 7.1)."""
