"""The figure of ruler x behaviour: both etas and their parts, each with its interval."""

from typing import TYPE_CHECKING

from harness.report.rows import BETTER, rewards_text
from harness.report.split_rows import SplitRow, has_parts, split_rows
from harness.report.summary.headline import WIDTH, headline, height_of, put_headline
from harness.report.summary.ratio_marks import ENDLESS, draw_marks
from harness.report.summary.svg import draw_svg
from harness.results.combination import Combination

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_splits(combination: Combination, missing: str = "") -> bytes | None:
    """eta_N and eta_P, each with both of its paths, as SVG; None where no part of either can be drawn."""
    rows = {name: split_rows(name, split) for name, split in combination.splits.items()}
    if not combination.is_split or not any(map(has_parts, rows.values())):
        return None
    title = f"Ruler x behaviour: {combination.group.title}: {rewards_text(combination)}"
    text = headline(combination, missing)
    return draw_svg(title, WIDTH, 4.0 + height_of(text), lambda figure: _fill(figure, rows, text))


def _fill(figure: "Figure", rows: dict[str, list[SplitRow]], text: str) -> None:
    put_headline(figure, text)
    grid = figure.subplots(1, len(rows), sharey=True, squeeze=False)
    for axes, (name, parts) in zip(grid[0], rows.items(), strict=True):
        draw_marks(axes, parts, with_intervals=True)
        axes.set_title(f"{name} = ruler x behaviour")
        axes.set_xlabel(f"ratio; {BETTER[name]} is called better")
        labels = ["eta", *(part.label for part in parts[1:])]
        axes.set_yticks([part.place for part in parts], labels)
        axes.set_ylim(7.2, -0.6)
    figure.supxlabel(ENDLESS, x=0.01, ha="left", fontsize=9)
