"""Cross-situational learning of gaze following: what is contingent in place of what co-occurs."""
