"""Figure 5.4: which modules are made, and when, with other caregivers."""
