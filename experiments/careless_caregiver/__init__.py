"""Figure 4.6: a caregiver who does not always look at objects."""
