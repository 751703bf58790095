"""Coding where a person looks from a video alone, without labels."""
