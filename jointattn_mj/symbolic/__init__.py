"""The discrete table worlds of chapters 4 and 5: spots, objects, and a caregiver who takes turns with the robot."""
