"""Chapter 5's mechanism without turns: how many minutes with a person its events take, with and without motion cues."""
