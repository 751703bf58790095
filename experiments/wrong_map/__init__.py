"""Why some sessions without motion cues hold on to a wrong map: one component at a time is made perfect."""
