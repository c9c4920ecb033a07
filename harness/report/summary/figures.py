"""The page's figures of a combination as files: accumulated reward, ruler x behaviour, learning.

Each is an SVG file with all that tells what it shows. `missing` tells of cells that are not done.
"""

from harness.eta.headline import SUCCESS
from harness.report.figures.accumulated import draw_panels
from harness.report.figures.learning import describe_learning, draw_learning
from harness.report.figures.points import FEWEST, POINTS
from harness.report.figures.split import draw_split
from harness.report.figures.split_rows import describe_split
from harness.report.rows.comparison import rewards_text, seeds_text
from harness.report.summary.svg import INTERVALS, Panel, draw_svg
from harness.results.comparison import Comparison
from harness.results.learning import Learning

OF_ALL_RUNS = 8_000
"""The most points of all runs in a figure together, about 70 kB."""
LEARNING_WIDTH, LEARNING_HEIGHT = 720.0, 250.0
"""Width of the figure of learning, which stands alone, and height of its panel, [px]."""
RUNS = (
    "Thin: one run per seed. Thick: their mean, which the indices are taken from. Shaded: Ω₁ below 0, which I_N sums, "
    "and Ω₂ above 0, which I_P sums."
)
LEARNING = "Lines: means over seeds. Bands: 95% intervals."


def runs_file(combination: Comparison, missing: str = "") -> bytes | None:
    """The figure of accumulated reward: all runs and their mean, a panel per reward; None without a finished pair."""
    runs = 2 * max(1, len(combination.seeds))
    charts = draw_panels(combination, max(FEWEST, min(POINTS, OF_ALL_RUNS // runs)))
    if charts is None:
        return None
    headings = (f"Baseline: {combination.baseline}", f"Proposed: {combination.proposed}")
    panels = [Panel(heading, chart) for heading, chart in zip(headings, charts, strict=True)]
    return _file("Accumulated reward", combination, missing, panels, [RUNS])


def split_file(combination: Comparison, missing: str = "") -> bytes | None:
    """The figure of both etas and their parts, each with its interval; None if no part of either can be drawn."""
    splits = combination.splits if combination.is_split else {}
    drawn = {name: draw_split(name, split) for name, split in splits.items()}
    panels = [Panel(f"{name} = ruler x behaviour", chart) for name, chart in drawn.items() if chart is not None]
    if not panels:
        return None
    told = [describe_split(name, split) for name, split in splits.items()]
    return _file("Ruler x behaviour", combination, missing, panels, [*told, INTERVALS])


def learning_file(combination: Comparison, learning: Learning, missing: str = "") -> bytes | None:
    """The figure of the success rate over environment steps, under both rewards; None if success has no metric."""
    if SUCCESS not in learning.random:
        return None
    chart = draw_learning(learning, SUCCESS)._replace(width=LEARNING_WIDTH, height=LEARNING_HEIGHT)
    notes = [LEARNING, describe_learning(learning, SUCCESS)]
    return _file("Success rate while learning", combination, missing, [Panel("", chart)], notes)


def _file(what: str, combination: Comparison, missing: str, panels: list[Panel], notes: list[str]) -> bytes:
    """A figure as a file. Above its panels stands what was compared where, over how many seeds, and what is missing."""
    where, rewards = combination.group.title, rewards_text(combination)
    seeds = seeds_text(combination.seeds) + (f"; {missing}" if missing else "")
    return draw_svg(f"{what}: {where}: {rewards}", (what, where, f"{rewards}, {seeds}"), panels, notes)
