"""The figure of learning: the success rate over environment steps, under both rewards and by random actions."""

from typing import TYPE_CHECKING, Any

from harness.eta.headline import SUCCESS
from harness.report.palette import BLUE, GREY, VERMILION
from harness.report.rows import rewards_text
from harness.report.summary.headline import WIDTH, headline, height_of, put_headline
from harness.report.summary.svg import draw_svg
from harness.results.combination import Combination
from harness.results.learning import Learning, LearningCurve

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def draw_learning(combination: Combination, learning: Learning, missing: str = "") -> bytes | None:
    """Means as lines, intervals as bands, random actions as a dotted line, as SVG; None where success has no metric."""
    if SUCCESS not in learning.random:
        return None
    title = f"Success rate while learning: {combination.group.title}: {rewards_text(combination)}"
    text = headline(combination, missing)
    return draw_svg(title, WIDTH, 3.7 + height_of(text), lambda figure: _fill(figure, learning, text))


def _fill(figure: "Figure", learning: Learning, text: str) -> None:
    from matplotlib.ticker import MaxNLocator, PercentFormatter

    put_headline(figure, text)
    axes = figure.subplots()
    _draw(axes, learning.baseline, BLUE, "o")
    _draw(axes, learning.proposed, VERMILION, "D")
    floor, last = learning.random[SUCCESS], learning.last_step(SUCCESS)
    if floor is not None:
        axes.plot((0, last), (floor, floor), ":", color=GREY, linewidth=1.6, label="random actions", clip_on=False)
    axes.set(xlim=(0, last), ylim=(-0.02, 1.02), xlabel="environment step", ylabel="success rate")
    axes.xaxis.set_major_locator(MaxNLocator(6, integer=True))
    axes.xaxis.set_major_formatter("{x:,.0f}")
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    figure.legend(loc="outside lower left", ncols=2, frameon=False)


def _draw(axes: "Axes", curve: LearningCurve, colour: str, shape: str) -> None:
    points, band = curve.known(SUCCESS), curve.band(SUCCESS)
    if band:
        steps, low, high = zip(*band, strict=True)
        axes.fill_between(steps, low, high, color=colour, alpha=0.18, linewidth=0)
    if not points:
        return
    means = [(point.steps, point.value.mean) for point in points if point.value.mean is not None]
    line: dict[str, Any] = {"linewidth": 2.0, "marker": shape, "markersize": 5, "clip_on": False, "zorder": 4}
    axes.plot(*zip(*means, strict=True), color=colour, label=curve.reward, **line)
