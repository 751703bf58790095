"""Figure 4.4: which event has the highest T^C, and when the robot stops to look."""
