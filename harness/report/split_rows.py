"""What a figure of ruler x behaviour shows, however it is drawn."""

from typing import NamedTuple

from harness.eta.decompose import Split
from harness.eta.index import Ratio
from harness.report.palette import GREEN, GREY, INK
from harness.report.ratio_axis import is_drawable
from harness.report.rows import ratio_text


class SplitRow(NamedTuple):
    """One ratio of a split."""

    label: str
    ratio: Ratio
    place: float
    """Down from the top."""
    colour: str
    symbol: str
    """``circle``, ``square`` or ``diamond``; ``-open`` behind it on the other path."""


def split_rows(name: str, split: Split) -> list[SplitRow]:
    """An eta and both of its paths, from top to bottom."""
    return [
        SplitRow(name, split.eta, 0.0, INK, "circle"),
        SplitRow("ruler", split.ruler, 1.3, GREY, "square"),
        SplitRow("behaviour", split.behaviour, 2.2, GREEN, "diamond"),
        SplitRow("ruler, other path", split.other_ruler, 3.5, GREY, "square-open"),
        SplitRow("behaviour, other path", split.other_behaviour, 4.4, GREEN, "diamond-open"),
    ]


def has_parts(rows: list[SplitRow]) -> bool:
    """Whether there is more to draw than the eta itself."""
    return any(is_drawable(row.ratio) for row in rows[1:])


def describe_split(name: str, split: Split) -> str:
    """The same in words."""
    first = f"ruler {ratio_text(split.ruler)} x behaviour {ratio_text(split.behaviour)}"
    other = f"ruler {ratio_text(split.other_ruler)} x behaviour {ratio_text(split.other_behaviour)}"
    return f"{name} {ratio_text(split.eta)} = {first}; other path: {other}."
