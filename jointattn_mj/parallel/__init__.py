"""Trials side by side: which backend computes them, and one whose images a graphics card draws."""
