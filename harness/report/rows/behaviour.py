"""Measures of behaviour as text, compared or of one reward alone: what terminal, page and summary share."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from harness.eta.behaviour_change import Change, Quantity
from harness.eta.headline import count_seeds
from harness.eta.index import NOTHING
from harness.eta.manner import DETERMINISTIC, STOCHASTIC
from harness.eta.swaps import p_text
from harness.record.plan_file import EXPERIMENT
from harness.report.rows.comparison import BETWEEN, EPISODES, count_of
from harness.report.rows.ratios import Grid, Text, format_number, value_rows
from harness.results import Results
from harness.results.alone import Alone, Stages
from harness.results.comparison import Comparison, StepChange
from harness.text import command_text, shortened

SAME_STEPS = "0, same steps"
"""In place of an interval where both robots take the same steps: nothing is estimated."""
SHOWN = 60
"""The most characters that are shown of the reason why a metric failed."""
HEADINGS = ("", "baseline", "proposed", "difference", "random", "better", "p", "result")


class BehaviourRow(NamedTuple):
    """One measure of the trained policies and of random actions, ready to print."""

    name: str
    baseline: str
    proposed: str
    difference: str
    random: str
    better: str
    p: str
    result: str


def behaviour_grids(comparison: Comparison) -> list[Grid]:
    """A grid for each manner in which behaviour was measured, the one that decides first."""
    manners = dict.fromkeys([comparison.manner, *(change.measure.manner for change in comparison.measured.changes)])
    grids = [_grid(comparison, manner) for manner in manners]
    return [grid for grid in grids if grid.rows]


def shown_changes(comparison: Comparison, manner: str) -> list[Change]:
    """The measures that have a value, those that decide first; below them those whose metric failed for every seed."""
    first, found = comparison.measured.deciding, comparison.measured.changes_of(manner)
    known = [
        replace(it, low=None, high=None) if is_same(comparison, it) else it for it in found if not is_undefined(it)
    ]
    known.sort(key=lambda change: first.index(change.name) if change.name in first else len(first))
    return [*known, *(it for it in found if it.reason and is_undefined(it))]


def is_undefined(change: Change) -> bool:
    """Whether the measure has a value under neither reward."""
    return (change.baseline, change.proposed) == (None, None)


def is_same(comparison: Comparison, change: Change) -> bool:
    """Whether there is no difference because both robots take the same steps, bit for bit."""
    return comparison.measured.same_steps and change.difference == 0.0


def behaviour_row(change: Change) -> BehaviourRow:
    """The row of a measure. If its metric failed for all seeds, the reason stands in place of the values.

    Args:
        change: The values of the measure.
    """
    name, text = measure_name(change.measure), text_of(change.measure)
    if change.reason and is_undefined(change):
        told = f"n/a ({shortened(change.reason, SHOWN)})"
        return BehaviourRow(name, told, *(NOTHING,) * 3, change.measure.better, NOTHING, "")
    return BehaviourRow(
        name,
        text(change.baseline),
        text(change.proposed),
        _difference(change, is_share=text is percentage),
        text(change.random),
        change.measure.better,
        p_text(change.corrected),
        change.direction,
    )


def along_grid(comparison: Comparison) -> Grid:
    """What each evaluation on the way hints at. None of them decides; the last row is the end of the trainings."""
    name = next(iter(comparison.measured.deciding), "").replace("_rate", "").replace("_", " ")
    headings = ("", f"{name}: baseline", "proposed", "difference", "exploratory")
    manner = comparison.own_manner
    moments = [*comparison.measured.along, StepChange(comparison.group.steps, comparison.measured.changes_of(manner))]
    rows = [_moment_row(comparison, moment) for moment in moments] if comparison.measured.along else []
    return Grid(headings, rows, [], f"Along the budget of training, {manner}")


def seeds_grid(comparison: Comparison) -> Grid:
    """What single seeds say where a mean may hide it, in the manner that decides."""
    headings = ("over seeds", "middle half: baseline", "proposed", "chance that a run is better")
    rows: list[tuple[str, ...]] = []
    for change in comparison.measured.changes_of(comparison.manner):
        if change.improvement is not None:
            middles = map(text_of(change.measure), change.middles)
            rows.append((measure_name(change.measure), *middles, f"{change.improvement:.0%}"))
    return Grid(headings, rows, [])


def _grid(comparison: Comparison, manner: str) -> Grid:
    rows: list[tuple[str, ...]] = []
    notes = []
    for change in shown_changes(comparison, manner):
        row = behaviour_row(change)
        rows.append(row._replace(difference=SAME_STEPS) if is_same(comparison, change) else row)
        notes += [_note(change)] if any(change.without) and not is_undefined(change) else []
    return Grid(HEADINGS, rows, notes, _title(comparison, manner))


def _note(change: Change) -> str:
    why = f" ({shortened(change.reason, SHOWN)})" if change.reason else ""
    name, (ours, theirs) = change.name.replace("_", " "), change.counts
    compared = count_seeds(ours) if ours == theirs else f"{count_seeds(ours)} against {theirs}"
    return f"{name}: {compared} compared, {sum(change.without)} without a value{why}"


def _title(comparison: Comparison, manner: str) -> str:
    """How the policies acted, and how many episodes were seen."""
    episodes = comparison.measured.episodes.get(manner)
    if episodes is None:
        return f"Behaviour {manner}"
    seen = count_of(comparison, manner, episodes)
    if manner in (DETERMINISTIC, STOCHASTIC):
        return f"Behaviour of the trained policies, {manner}, {seen} per seed"
    where = comparison.measured.counted.get(manner, EPISODES).where
    # trainings need not have the same number of episodes
    return f"Behaviour {manner}, {f'{seen} or more per seed {where}'.rstrip()}"


def _moment_row(comparison: Comparison, moment: StepChange) -> tuple[str, ...]:
    """The row of an evaluation, with what it hints at."""
    decisive = next((change for change in moment.changes if change.name in comparison.measured.deciding[:1]), None)
    told = behaviour_row(decisive) if decisive else None
    values = (told.baseline, told.proposed, told.difference) if told else (NOTHING,) * 3
    return (f"after {moment.steps:,} steps", *values, moment.answer)


def measure_name(measure: Quantity) -> str:
    """The name of a measure, with its unit."""
    name, unit = measure.title or measure.name.replace("_", " "), measure.unit
    return f"{name} [{unit}]" if unit and unit not in name.split() else name


def text_of(measure: Quantity) -> Text:
    """The function that writes values of a measure: as a percentage if it is a share, else as a number."""
    return percentage if measure.is_share and not measure.unit else format_number


def _difference(change: Change, is_share: bool) -> str:
    """The interval of proposed - baseline."""
    if change.low is None or change.high is None:
        return NOTHING
    if is_share:  # percentage points
        return f"[{100 * change.low + 0.0:.1f}, {100 * change.high + 0.0:.1f}] pp"
    return f"[{format_number(change.low)}, {format_number(change.high)}]"


def percentage(value: float | None) -> str:
    """A share as a percentage."""
    return NOTHING if value is None else f"{value:.1%}"


ALONE_HEADINGS = ("an episode", "start", "end", "evaluation", "random")
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
    return Grid(ALONE_HEADINGS, rows, [])


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
