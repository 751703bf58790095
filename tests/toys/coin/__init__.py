"""Coins that are thrown."""
