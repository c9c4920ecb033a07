"""Measures of behaviour as text: what the terminal, the page and the summary share."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple, TypeAlias

from harness.eta.behaviour_change import Change, Quantity
from harness.eta.headline import count_seeds
from harness.eta.index import NOTHING
from harness.eta.interval import SHARE
from harness.eta.manner import DETERMINISTIC, STOCHASTIC
from harness.eta.swaps import p_text
from harness.report.rows.comparison import EPISODES, count_of
from harness.report.rows.ratios import Grid, format_number
from harness.results.comparison import Comparison, StepChange
from harness.text import shortened

SAME_STEPS = "0, same steps"
"""In place of an interval where both robots take the same steps: nothing is estimated."""
SHOWN = 60
"""The most characters that are shown of the reason why a metric failed."""
HEADINGS = ("", "baseline", "proposed", "difference", "random", "better", "p", "result")


Text: TypeAlias = Callable[[float | None], str]
"""A function that writes a value as text."""


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


def defined_changes(comparison: Comparison, manner: str) -> list[Change]:
    """The measures, those that decide first. A measure that is not defined under either reward is left out."""
    measured, nothing = comparison.measured, (None, None)
    known = [it for it in measured.changes_of(manner) if (it.baseline, it.proposed) != nothing]
    changes = [replace(it, low=None, high=None) if is_same(comparison, it) else it for it in known]
    first = measured.deciding
    return sorted(changes, key=lambda change: first.index(change.name) if change.name in first else len(first))


def is_same(comparison: Comparison, change: Change) -> bool:
    """Whether there is no difference because both robots take the same steps, bit for bit."""
    return comparison.measured.same_steps and change.difference == 0.0


def failed_changes(comparison: Comparison, manner: str) -> list[Change]:
    """The measures whose metric failed for every seed. They stand below the others, with the reason."""
    defined = {change.name for change in defined_changes(comparison, manner)}
    return [change for change in comparison.measured.changes_of(manner) if change.reason and change.name not in defined]


def behaviour_row(change: Change) -> BehaviourRow:
    """The row of a measure. If its metric failed for all seeds, the reason stands in place of the values.

    Args:
        change: The values of the measure.
    """
    text = text_of(change)
    if change.reason and (change.baseline, change.proposed) == (None, None):
        told = f"n/a ({shortened(change.reason, SHOWN)})"
        return BehaviourRow(_name(change), told, *(NOTHING,) * 3, change.measure.better, NOTHING, "")
    return BehaviourRow(
        _name(change),
        text(change.baseline),
        text(change.proposed),
        _difference(change, is_share=text is percentage),
        text(change.random),
        change.measure.better,
        p_text(change.corrected),
        change.direction,
    )


def value_text(change: Change, value: float) -> str:
    """A value of a measure, written as the measure's means are."""
    return text_of(change)(value)


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
            text = text_of(change)
            rows.append((_name(change), *map(text, change.middles), f"{change.improvement:.0%}"))
    return Grid(headings, rows, [])


def _grid(comparison: Comparison, manner: str) -> Grid:
    ordered = defined_changes(comparison, manner)
    notes = [_note(change) for change in ordered if any(change.without)]
    same = [is_same(comparison, change) for change in ordered]
    known = [
        row._replace(difference=SAME_STEPS) if alike else row
        for row, alike in zip(map(behaviour_row, ordered), same, strict=True)
    ]
    rows = [tuple(row) for row in (*known, *map(behaviour_row, failed_changes(comparison, manner)))]
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


def _name(change: Change) -> str:
    return measure_name(change.measure)


def measure_name(measure: Quantity) -> str:
    """The name of a measure, with its unit."""
    name, unit = measure.title or measure.name.replace("_", " "), measure.unit
    return f"{name} [{unit}]" if unit and unit not in name.split() else name


def text_of(change: Change) -> Text:
    """The function that writes values of a measure: as a percentage if it is a share, else as a number."""
    return text_of_measure(change.measure)


def text_of_measure(measure: Quantity) -> Text:
    """See `text_of`."""
    is_share = not measure.unit and (measure.episodes is not None or measure.bounds == SHARE)
    return percentage if is_share else format_number


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
