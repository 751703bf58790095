"""Figure 4.5: how the number of objects, and how the caregiver responds, change what can be found."""
