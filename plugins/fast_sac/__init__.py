"""Soft actor-critic with numpy alone: the large arrays are allocated once, every gradient is written out."""
