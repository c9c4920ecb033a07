"""What a report says, as plain data. Terminal, page, summary and records show it, and compute nothing."""

from harness.report.section import Fact as Fact, Grid as Grid

STYLES = {
    "HELPS": "bold green",
    "HURTS": "bold red",
    "LEARNS FASTER": "green",
    "LEARNS SLOWER": "red",
    "MIXED": "bold magenta",
    "AHEAD SO FAR": "cyan",
    "BEHIND SO FAR": "cyan",
}
"""Styles of rich for the words of answers in a terminal. The words say everything without a colour too."""
