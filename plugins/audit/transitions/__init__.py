"""Rewards as functions of a transition, asked about steps that nobody took: EPIC, DARD and STARC in any environment."""
