"""One reward alone, as text: what was asked, what it paid, what its policies did. No word of better or worse."""

from collections.abc import Sequence

from harness.eta.index import NOTHING
from harness.eta.seed_mean import SeedMean
from harness.record.plan_file import EXPERIMENT
from harness.report.apart import BETWEEN
from harness.report.rows.behaviour import Text, measure_name, text_of_measure
from harness.report.rows.ratios import Grid
from harness.results import Results
from harness.results.alone import Alone, Stages
from harness.text import command_text

HEADINGS = ("an episode", "start", "end", "evaluation", "random")
ALONE = (
    "Means over trainings. Start and end are the first and the last tenth of the episodes of each training, evaluation "
    "those of the final policies. Nothing is compared: whether another reward would teach more, or the same, cannot be "
    "seen here."
)


def size_text(alone: Alone) -> str:
    """How many trainings there are, and how long they are."""
    count = len(alone.seeds)
    if count == 1:
        return f"1 training, {alone.group.steps:,} steps"
    return f"{count} trainings, {alone.group.steps:,} steps each"


def setting_of(alone: Alone) -> str:
    """Where the trainings took place, how many there are, and how long they are."""
    return BETWEEN.join((size_text(alone), alone.group.title))


def alone_grid(alone: Alone, most: int | None = None, *, with_intervals: bool = True) -> Grid:
    """The pay, then a row for each measure, its interval below it.

    Args:
        alone: The reward.
        most: So many measures at most; None for all.
        with_intervals: Whether to show intervals.
    """
    rows: list[tuple[str, ...]] = []
    for stages in (alone.paid, *alone.behaviour[:most]):
        text = text_of_measure(stages.measure)
        means = (stages.start, stages.end, stages.evaluation)
        rows.append((measure_name(stages.measure), *(text(it.mean) for it in means), text(stages.random)))
        intervals = [_interval(it, text) for it in means]
        rows += [("  95% interval", *intervals, "")] if with_intervals and any(intervals) else []
    return Grid(HEADINGS, rows, [])


def story(alone: Alone) -> str:
    """Pay against behaviour over the training, in a sentence; empty where it is not known."""
    told = {"pay of an episode": alone.paid, **{measure_name(it.measure): it for it in alone.behaviour[:1]}}
    ways = [f"the {name} {_way(it)}" for name, it in told.items() if it.start.mean is not None]
    return f"Over the trainings: {'; '.join(ways)}." if ways else ""


def beside(results: Results, alone: Sequence[Alone]) -> str:
    """The command that trains another reward beside one that stands alone; empty where no experiment made it."""
    if not alone or results.is_temporary or not results.is_experiment:
        return ""
    place = results.folder / EXPERIMENT
    command = command_text("harness", "run", place, "--reward", "OTHER", "--out", results.folder)
    return f"{command}{results.plugin_flags}"


def _way(stages: Stages) -> str:
    text = text_of_measure(stages.measure)
    return f"from {text(stages.start.mean)} to {text(stages.end.mean)}"


def _interval(mean: SeedMean, text: Text) -> str:
    if mean.low is None or mean.high is None or mean.low == mean.high or mean.mean is None:
        return ""
    ends = text(mean.low), text(mean.high)
    return "" if NOTHING in ends else f"[{ends[0]}, {ends[1]}]"
