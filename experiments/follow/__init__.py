"""The task ``follow`` as a benchmark for learners that are rewarded: PPO, from the state and from images."""
