"""Summaries of an experiment: records and figures that are small enough to be kept beside the code."""

from .read import committed_table, committed_text, is_committed, refuse_committed
from .records import write_summary
from .svg import TitledChart, draw_svg

__all__ = [
    "TitledChart",
    "committed_table",
    "committed_text",
    "draw_svg",
    "is_committed",
    "refuse_committed",
    "write_summary",
]
