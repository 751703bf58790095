"""Where a person in a video looks, look by look, learned from the video itself without a label."""
