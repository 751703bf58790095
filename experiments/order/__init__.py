"""Section 5.3.2: gaze following, then looking back, then gaze alternation."""
