"""Figure 5.5: how each module changes what the robot does."""
