"""What stands above a figure: it may be seen without the page around it."""

import textwrap
from typing import TYPE_CHECKING

from harness.report.rows import rewards_text, seeds_text
from harness.results.combination import Combination

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CHARACTERS = 100
"""On a line of a figure that is WIDTH wide."""
WIDTH = 9.0
"""Of most figures, [inch]."""
LINE = 0.17
"""Height of a line of text, [inch]."""


def headline(combination: Combination, missing: str) -> str:
    """Where the two rewards were compared, which, over how many seeds, and what is missing."""
    seeds = seeds_text(combination.seeds) + (f"; {missing}" if missing else "")
    lines = [combination.group.title, f"{rewards_text(combination)}, {seeds}"]
    return "\n".join(textwrap.fill(line, CHARACTERS) for line in lines)


def height_of(text: str) -> float:
    """What lines of text take, [inch]."""
    return LINE * (text.count("\n") + 1)


def put_headline(figure: "Figure", text: str) -> None:
    """To the left, above everything else."""
    figure.suptitle(text, x=0.01, ha="left", fontsize=10.5)
