"""Figure 5.3: the contingency of events over time, in one run."""
