"""Recorded runs, paid again under other rewards."""
