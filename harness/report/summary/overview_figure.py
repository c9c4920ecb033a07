"""Every combination at a glance: eta_N and eta_P, each with ruler and behaviour."""

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

from harness.report.apart import tell_apart
from harness.report.palette import GREEN, GREY, GRID, INK
from harness.report.rows import BETTER, SCALES
from harness.report.split_rows import SplitRow
from harness.report.summary.headline import height_of, put_headline
from harness.report.summary.ratio_marks import ENDLESS, draw_marks
from harness.report.summary.svg import draw_svg
from harness.results.combination import Combination

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LINE = 44
"""Characters of a name."""
REWARD = 4
"""Place of the proposed reward in a name."""


def draw_overview(combinations: Sequence[Combination], missing: Sequence[str]) -> bytes | None:
    """A row per combination, as SVG; None without a combination that has a finished pair.

    Args:
        combinations: Rows, from top to bottom; one without a finished pair has a row too.
        missing: Of each, which of its cells are not done.
    """
    if not any(combination.seeds for combination in combinations):
        return None
    shared, names = name_apart(combinations)
    labels = [_label(*given) for given in zip(names, combinations, missing, strict=True)]
    row = max(0.62, *(height_of(label) + 0.15 for label in labels))
    height = 1.7 + height_of(shared) + row * len(labels)
    title = "eta = ruler x behaviour of every combination"
    return draw_svg(title, 10.0, height, lambda figure: _fill(figure, combinations, labels, shared))


def name_apart(combinations: Sequence[Combination]) -> tuple[str, list[str]]:
    """What all combinations share, and for each what it does not."""
    told = [_parts(combination) for combination in combinations]
    apart = tell_apart(told, keep=REWARD if len(told) == 1 else None)
    return textwrap.fill(apart.shared, 110), apart.names


def _parts(combination: Combination) -> tuple[str, ...]:
    group = combination.group
    manner = f"{group.steps:,} steps, evaluated {group.manner}"
    proposed = combination.proposed + " (A/A)" * (combination.proposed == combination.baseline)
    return (*group.labels.values(), proposed, f"against {combination.baseline}", manner)


def _label(name: str, combination: Combination, missing: str) -> str:
    count = len(combination.seeds)
    told = [name, f"{count} seed{'s' * (count != 1)}" + (f"; {missing}" if missing else "")]
    return "\n".join(textwrap.fill(line, LINE) for line in told if line)


def _fill(figure: "Figure", combinations: Sequence[Combination], labels: list[str], shared: str) -> None:
    put_headline(figure, shared)
    grid = figure.subplots(1, 2, sharey=True, squeeze=False)
    for axes, name in zip(grid[0], BETTER, strict=True):
        rows = [row for place, combination in enumerate(combinations) for row in _rows(combination, name, place)]
        for place in range(1, len(combinations), 2):
            axes.axhspan(place - 0.5, place + 0.5, color=GRID, alpha=0.4, linewidth=0, zorder=0)
        draw_marks(axes, rows, with_intervals=False)
        axes.set_title(name)
        axes.set_xlabel(f"ratio; {BETTER[name]} is called better")
        axes.set_yticks(range(len(labels)), labels)
        axes.set_ylim(len(labels) - 0.5, -0.5)
    _explain(figure)


def _rows(combination: Combination, name: str, place: int) -> list[SplitRow]:
    """The first path alone: the other one is in the combination's own figure."""
    split = combination.splits[name]
    return [
        SplitRow(name, split.eta, place - 0.27, INK, "circle"),
        SplitRow("ruler", split.ruler, place, GREY, "square"),
        SplitRow("behaviour", split.behaviour, place + 0.27, GREEN, "diamond"),
    ]


def _explain(figure: "Figure") -> None:
    from matplotlib.lines import Line2D

    kinds = (("eta, equal to", INK, "o"), ("ruler times", GREY, "s"), ("behaviour", GREEN, "D"))
    handles = [Line2D([], [], color=colour, marker=shape, label=name) for name, colour, shape in kinds]
    figure.legend(
        handles=handles,
        loc="outside lower left",
        ncols=3,
        frameon=False,
        title=f"{SCALES}\n{ENDLESS}",
        alignment="left",
    )
