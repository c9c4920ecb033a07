"""The rows of a figure of ruler x behaviour."""

from typing import NamedTuple

from harness.eta.index import Ratio
from harness.eta.splits import Split
from harness.report.figures.chart import Shape
from harness.report.rows.ratios import ratio_text

PATHS = (("proposed runs", 3.5), ("baseline's runs", 6.7))
"""The names of both paths, and where their rows begin, counted down from the top."""


class SplitRow(NamedTuple):
    """One ratio of a split."""

    label: str
    ratio: Ratio
    place: float
    """The place of the row, counted down from the top."""
    colour: str
    """The name of its colour, as in `harness.report.figures.chart`."""
    shape: Shape
    is_open: bool = False
    """Whether the ratio is that of a single path, which is drawn as an open dot."""


def split_rows(name: str, split: Split) -> list[SplitRow]:
    """An eta, its split, and both paths whose mean the split is, from top to bottom."""
    rows = [
        SplitRow(name, split.eta, 0.0, "ink", "circle"),
        SplitRow("ruler", split.ruler, 1.2, "ruler", "square"),
        SplitRow("behaviour", split.behaviour, 2.2, "behaviour", "diamond"),
    ]
    for (where, top), path in zip(PATHS, split.paths, strict=False):
        rows += [
            SplitRow(f"ruler, {where}", path.ruler, top + 0.9, "ruler", "square", True),
            SplitRow(f"behaviour, {where}", path.behaviour, top + 1.9, "behaviour", "diamond", True),
        ]
    return rows


def describe_split(name: str, split: Split) -> str:
    """The same in words."""
    parts = f"ruler {ratio_text(split.ruler)} x behaviour {ratio_text(split.behaviour)}"
    return f"{name} {ratio_text(split.eta)} = {parts}; interaction {ratio_text(split.interaction)}."
