"""Evaluations of policies: what they share, when they happen, what they are compared with."""
