"""Chapter 5's mechanism in real time: how many minutes with a person its events take, with and without motion cues."""
