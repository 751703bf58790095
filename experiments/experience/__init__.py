"""Figure 4.7: what the robot has experienced when it found an object."""
