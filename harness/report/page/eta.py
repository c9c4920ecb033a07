"""Two groups of recorded runs compared, as one HTML file that opens anywhere, offline."""

from pathlib import Path

from harness.eta.curve import GroupCurve
from harness.eta.scored_sums import BB, KK
from harness.report.figures.accumulated import draw_curve
from harness.report.figures.chart import Chart, Line, linear_axis
from harness.report.figures.draw import draw_chart
from harness.report.page.page import render_page, write_page
from harness.report.tables.eta import comparison_title, runs_text
from harness.score.compare import Comparison

TEMPLATE = Path(__file__).parent / "eta.html.j2"
FIGURE = "The {kind} reward of every run over environment steps, and the mean of each group."


def write_eta_page(comparison: Comparison, path: Path) -> None:
    """Write every run's curve and the means to `path`, in one go: a reader finds the old file or the new one, whole.

    Raises:
        UsageError: A library of the extra ``report`` is missing, or `path` cannot be written.
    """
    page = render_page(
        TEMPLATE,
        "--plot",
        title=comparison_title(comparison),
        runs=runs_text(comparison),
        number=comparison.number,
        figure=draw_chart(draw_groups(comparison), FIGURE.format(kind=comparison.kind)),
    )
    write_page(page, path, "The figure")


def draw_groups(comparison: Comparison) -> Chart:
    """Both groups in one panel: a thin line per run, a thick one for their mean."""
    lines = [
        line
        for who, pair in (("baseline", BB), ("proposed", KK))
        for line in _group_lines(comparison.curves[pair], who)
    ]
    low, high = (bound(bound(line.y) for line in lines) for bound in (min, max))
    air = 0.04 * (high - low) or 1.0
    last = max(1.0, *(line.x[-1] for line in lines))
    return Chart(
        linear_axis(0.0, last, "environment step", 5),
        linear_axis(low - air, high + air, f"{comparison.kind} reward"),
        tuple(lines),
        height=260.0,
    )


def _group_lines(curve: GroupCurve, who: str) -> list[Line]:
    runs = curve.runs
    lines = [
        draw_curve(run, curve.stride, f"{who} run {number}", who)._replace(width=1.0, opacity=0.5)
        for number, run in enumerate(runs, 1)
    ]
    mean = draw_curve(runs.mean(axis=0), curve.stride, f"{who}, mean of {len(runs)}", who)
    return [*lines, mean._replace(width=3.0, in_legend=True)]
