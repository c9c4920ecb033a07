"""Two groups of recorded runs compared, as one HTML file that opens anywhere, offline."""

from dataclasses import replace
from pathlib import Path

from harness.eta.curve import GroupCurve
from harness.eta.headline import Answer
from harness.eta.splits import BB, KK
from harness.report.facts import Compared
from harness.report.figures.accumulated import draw_curve
from harness.report.figures.chart import Chart, Line, linear_axis
from harness.report.figures.draw import draw_chart
from harness.report.figures.split import describe_split, draw_split
from harness.report.page.answer import Card
from harness.report.page.comparison import Panel, Section
from harness.report.page.html import Page, render
from harness.report.page.page import write_page
from harness.report.rows import Fact
from harness.report.rows.comparison import badge_of, word_of
from harness.report.rows.ratios import SPLIT, comparison_title, eta_facts, eta_grids, runs_text
from harness.score.compare import ComparedRuns

FIGURE = "The {kind} reward of every run over environment steps, and the mean of each group."
THIN = "Thin: one line per run. Thick: the mean of a group, which the indices are taken from."
NO_VERDICT = (
    "Nothing says how the robot behaves: these files have rewards alone. Rewards cannot tell whether it behaves "
    "better, or only the numbers are bigger."
)


def write_eta_page(comparison: ComparedRuns, path: Path) -> None:
    """Write every run's curve and the means to `path`, in one go: a reader finds the old file or the new one, whole.

    Raises:
        UsageError: A library of the extra ``report`` is missing, or `path` cannot be written.
    """
    page = Page(
        question=comparison_title(comparison),
        comparisons=[_section(comparison)],
        is_open=True,
        subject="robot",
        cells=Fact(runs_text(comparison)),
        counted="Runs",
        numbers_mean=SPLIT,
        is_curve_open=True,
    )
    write_page(render(page, "--plot"), path, "The figure")


def _section(comparison: ComparedRuns) -> Section:
    """What the template shows of both groups."""
    splits = comparison.decomposition.splits.items()
    drawn = [(name, draw_split(name, split), describe_split(name, split)) for name, split in splits]
    figure = draw_chart(draw_groups(comparison), FIGURE.format(kind=comparison.kind))
    cannot = Answer.CANNOT_TELL
    card = Card(runs_text(comparison), word_of(cannot), badge_of(cannot), NO_VERDICT, (), "", pay=comparison.number)
    return Section(
        card=card,
        told=Compared(
            [replace(it, grids=()) for it in eta_facts(comparison)],
            numbers=[grid for grid in eta_grids(comparison) if grid.rows or grid.notes],
        ),
        number=True,
        indices=[
            Panel(f"{name} = ruler x behaviour", draw_chart(chart, told), told)
            for name, chart, told in drawn
            if chart is not None
        ],
        curves=[Panel("Both groups", figure, THIN)],
    )


def draw_groups(comparison: ComparedRuns) -> Chart:
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
