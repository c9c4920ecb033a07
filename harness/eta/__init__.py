"""Computes numbers and words from numbers: the note's indices, their ratios, and how far these can be trusted."""
