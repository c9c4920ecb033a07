"""The figure of the published experiment: the accumulated reward of every run, and their mean, per reward."""

import textwrap
from typing import TYPE_CHECKING, Any

from harness.report.palette import GREY, INK
from harness.report.panel import Panel, panels_of, reward_range, step_range
from harness.report.points import select_points
from harness.report.regions import regions_of
from harness.report.rows import rewards_text
from harness.report.summary.headline import WIDTH, headline, height_of, put_headline
from harness.report.summary.svg import draw_svg
from harness.results.combination import Combination

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

POINTS = 4_000
"""Of all curves and regions of a figure together: about 80 kB."""
FEWEST, MOST = 40, 500
"""Of one curve."""


def draw_runs(combination: Combination, missing: str = "") -> bytes | None:
    """Both panels side by side on equal axes, as SVG; None without a finished pair.

    `missing` tells of cells that are not done.
    """
    panels = panels_of(combination)
    if panels is None:
        return None
    title = f"Accumulated reward: {combination.group.title}: {rewards_text(combination)}"
    text = headline(combination, missing)
    names = height_of(max((_name(panel) for panel in panels), key=len))
    return draw_svg(title, WIDTH, 3.7 + names + height_of(text), lambda figure: _fill(figure, panels, text))


def _fill(figure: "Figure", panels: tuple[Panel, Panel], text: str) -> None:
    from matplotlib.ticker import MaxNLocator

    put_headline(figure, text)
    grid = figure.subplots(1, len(panels), sharex=True, sharey=True, squeeze=False)
    for axes, panel in zip(grid[0], panels, strict=True):
        _draw(axes, panel, step_range(panels)[1])
        axes.set(xlim=step_range(panels), ylim=reward_range(panels), xlabel="environment step")
        axes.xaxis.set_major_formatter("{x:,.0f}")
        axes.xaxis.set_major_locator(MaxNLocator(5, integer=True))
        axes.yaxis.set_major_formatter(lambda value, _: f"{value:,.12g}")
    grid[0][0].set_ylabel("accumulated shaped reward")


def _draw(axes: "Axes", panel: Panel, last: float) -> None:
    """Thin runs, the thick mean, its regions, and both marked steps."""
    points = max(FEWEST, min(MOST, POINTS // (2 * len(panel.runs) + 6)))  # a region goes there and back
    for values, width, alpha in [*((run, 0.8, 0.5) for run in panel.runs), (panel.mean, 2.6, 1.0)]:
        steps = select_points(values, points)
        axes.plot(steps * panel.stride, values[steps], color=panel.colour, linewidth=width, alpha=alpha)
    for region in regions_of(panel, points):
        axes.fill_between(region.x, region.y, color=panel.colour, alpha=0.18, linewidth=0)
        if region.has_room(last):
            axes.annotate(region.name, region.centre, ha="center", va="center", fontsize=11, zorder=6)
    axes.axhline(0.0, color=GREY, linewidth=1.0, zorder=1)
    for name, step in panel.marks.items():
        axes.axvline(step, color=INK, linewidth=0.8, linestyle=":", zorder=1)
        _label(axes, f"{name}: step {step:,}", step, name == "first negative", step < last / 2)
    dots: dict[str, Any] = {
        "markerfacecolor": "#ffffff",
        "markeredgecolor": panel.colour,
        "markeredgewidth": 1.8,
        "markersize": 6,
    }
    if panel.marks:  # a line without points has no place in the layout
        axes.plot(list(panel.marks.values()), panel.heights, "o", clip_on=False, zorder=5, **dots)
    axes.set_title(_name(panel), pad=34)


def _name(panel: Panel) -> str:
    return textwrap.fill(f"{panel.role}: {panel.reward}", 44)


def _label(axes: "Axes", text: str, step: int, upper: bool, begins: bool) -> None:
    """A line of text above the panel, where no curve can cover it; each name has a line of its own."""
    axes.annotate(
        text,
        (step, 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(0, 16 if upper else 3),
        textcoords="offset points",
        ha="left" if begins else "right",
        fontsize=9,
    )
