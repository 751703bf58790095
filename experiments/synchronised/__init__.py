"""The synchronised run from which the gate was set (section 6.4.1, Fig. 6.7)."""
