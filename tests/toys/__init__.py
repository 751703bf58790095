"""Claims to test the laboratory with."""
