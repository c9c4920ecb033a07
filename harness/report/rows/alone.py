"""One reward alone, as text: what was asked, what it paid, what its policies did. No word of better or worse."""

from collections.abc import Sequence

from harness.record.plan_file import EXPERIMENT
from harness.report.rows.behaviour import measure_name, text_of
from harness.report.rows.comparison import BETWEEN
from harness.report.rows.ratios import Grid, value_rows
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


def alone_grid(alone: Alone, most: int | None = None) -> Grid:
    """The pay, then a row for each measure; of `most` measures at most, or of all, each with its interval below it."""
    rows: list[tuple[str, ...]] = []
    for stages in (alone.paid, *alone.behaviour[:most]):
        values = (stages.start, stages.end, stages.evaluation, stages.random)
        told = value_rows(measure_name(stages.measure), values, text_of(stages.measure))
        rows += told[:1] if most else told
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
    text = text_of(stages.measure)
    return f"from {text(stages.start.mean)} to {text(stages.end.mean)}"
