"""Cells whose task is any Gymnasium environment: how they are planned, and how they are done."""
