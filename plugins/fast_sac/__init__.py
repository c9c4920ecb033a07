"""Soft actor-critic with numpy alone. The large arrays are allocated once, and each gradient is coded by hand."""
