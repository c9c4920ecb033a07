"""The page's figures as files: accumulated reward, ruler x behaviour and learning of a combination; the race.

Each is an SVG file with all that tells what it shows. `missing` tells of cells that are not done.
"""

from harness.report.figures.accumulated import draw_panels
from harness.report.figures.learning import describe_learning, draw_learning, learning_heading, learning_names
from harness.report.figures.points import FEWEST, POINTS
from harness.report.figures.race import draw_race
from harness.report.figures.split import draw_split
from harness.report.figures.split_rows import describe_split
from harness.report.rows.behaviour import text_of
from harness.report.rows.comparison import format_number, rewards_text, seeds_text
from harness.report.rows.numbers import splits_of
from harness.report.rows.race import TITLE as RACE_TITLE
from harness.report.rows.race import RaceTold
from harness.report.rows.returns import MEAN
from harness.report.summary.svg import INTERVALS, TitledChart, draw_svg
from harness.results.comparison import Comparison
from harness.results.learning import Learning

OF_ALL_RUNS = 8_000
"""The most points of all runs in a figure together, about 70 kB."""
LEARNING_WIDTH, LEARNING_HEIGHT = 720.0, 250.0
"""Width of the figure of learning, and height of its panels, [px]."""
PANELS = 3
"""How many panels it has, side by side."""
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
    panels = [TitledChart(heading, chart) for heading, chart in zip(headings, charts, strict=True)]
    return _file("Accumulated reward", combination, missing, panels, [RUNS])


def split_file(combination: Comparison, missing: str = "") -> bytes | None:
    """The figure of every eta and its parts, each with its interval; None if no part of any can be drawn."""
    splits = splits_of(combination)
    drawn = {name: draw_split(name, split) for name, split in splits.items()}
    headings = {"eta": f"{MEAN} {combination.manner}: eta = ruler x behaviour"}
    panels = [
        TitledChart(headings.get(name, f"{name} = ruler x behaviour"), chart)
        for name, chart in drawn.items()
        if chart is not None
    ]
    if not panels:
        return None
    told = [describe_split(name, split) for name, split in splits.items()]
    return _file("Ruler x behaviour", combination, missing, panels, [*told, INTERVALS])


def race_file(told: RaceTold) -> bytes:
    """The figure of a race: what decides over the seeds, a line for each reward."""
    return draw_svg(RACE_TITLE, [RACE_TITLE, told.sentence], [TitledChart("", draw_race(told))])


def learning_file(combination: Comparison, learning: Learning, missing: str = "") -> bytes | None:
    """The figure of the first measures over environment steps, under both rewards; None if none is known."""
    names = learning_names(learning, combination)[:PANELS]
    if not names:
        return None
    texts = {change.name: text_of(change) for change in combination.changes_of(combination.manner)}
    of_each = {name: texts.get(name, format_number) for name in names}
    charts = {name: draw_learning(learning, name, text) for name, text in of_each.items()}
    told = [f"{learning_heading(name)}: {describe_learning(learning, name, text)}" for name, text in of_each.items()]
    width = LEARNING_WIDTH / len(names)
    panels = [
        TitledChart(learning_heading(name), chart._replace(width=width, height=LEARNING_HEIGHT))
        for name, chart in charts.items()
    ]
    return _file("Learning", combination, missing, panels, [LEARNING, *told])


def _file(what: str, combination: Comparison, missing: str, panels: list[TitledChart], notes: list[str]) -> bytes:
    """A figure as a file. Above its panels stands what was compared where, over how many seeds, and what is missing."""
    where, rewards = combination.group.title, rewards_text(combination)
    seeds = seeds_text(combination.seeds) + (f"; {missing}" if missing else "")
    return draw_svg(f"{what}: {where}: {rewards}", (what, where, f"{rewards}, {seeds}"), panels, notes)
