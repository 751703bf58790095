"""Values of sensations and actions that split where contingency rises (section 7.1)."""
