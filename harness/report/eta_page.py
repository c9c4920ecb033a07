"""Two groups of recorded runs compared, as one HTML file that opens anywhere, offline."""

from pathlib import Path

from harness.eta.curve import GroupCurve, Kind
from harness.eta.scored_sums import BB, KK
from harness.report.eta_table import comparison_title, runs_text
from harness.report.figure import Figure, draw_curve
from harness.report.page import render_page, write_page
from harness.report.palette import BLUE, FONT, GRID, INK, VERMILION
from harness.score.compare import Comparison

TEMPLATE = Path(__file__).parent / "eta.html.j2"


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
        kind=comparison.kind,
        figure=draw_groups(comparison),
    )
    write_page(page, path, "The figure")


def draw_groups(comparison: Comparison) -> Figure:
    """Both groups in one panel: a thin line per run, a thick one for their mean."""
    baseline = _group_lines(comparison.curves[BB], "baseline", BLUE)
    proposed = _group_lines(comparison.curves[KK], "proposed", VERMILION)
    return {"data": [*baseline, *proposed], "layout": _layout(comparison.kind)}


def _group_lines(curve: GroupCurve, who: str, colour: str) -> list[Figure]:
    runs = curve.runs
    thin, thick = {"color": colour, "width": 1}, {"color": colour, "width": 3.5}
    lines = [
        {**draw_curve(run, curve.stride, f"{who} run {number}", thin, opacity=0.4), "showlegend": False}
        for number, run in enumerate(runs, 1)
    ]
    return [*lines, draw_curve(runs.mean(axis=0), curve.stride, f"{who}, mean of {len(runs)}", thick)]


def _layout(kind: Kind) -> Figure:
    axis = {"showline": True, "linecolor": INK, "gridcolor": GRID, "automargin": True}
    return {
        "font": {"family": FONT, "size": 13, "color": INK},
        "plot_bgcolor": "#ffffff",
        "height": 520,
        "showlegend": True,
        "legend": {"orientation": "h", "y": 1.1},
        "xaxis": {**axis, "title": {"text": "environment step"}, "tickformat": ",d"},
        "yaxis": {**axis, "title": {"text": f"{kind} reward"}, "zerolinecolor": "#767676"},
    }
