"""Soft actor-critic with numpy alone: every array is allocated once, every gradient is written out."""
