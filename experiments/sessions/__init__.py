"""Gaze following in real time, with and without motion cues (section 6.4.3, Fig. 6.8)."""
