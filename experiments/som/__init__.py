"""The map of face patterns (section 6.4.1, Fig. 6.6)."""
