"""Measures of behaviour as text: what the terminal, the page and the summary share."""

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

from harness.eta.behaviour_change import Change
from harness.eta.headline import SUCCESS, count_seeds
from harness.report.rows.comparison import Grid, format_number, format_p
from harness.results.comparison import Comparison, StepChange
from harness.results.measured import TRAINING
from harness.results.overview import NOTHING
from harness.text import shortened

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


def behaviour_grids(combination: Comparison) -> list[Grid]:
    """A grid for each manner in which behaviour was measured, the one that decides first."""
    manners = dict.fromkeys([combination.manner, *(change.measure.manner for change in combination.changes)])
    grids = [_grid(combination, manner) for manner in manners]
    return [grid for grid in grids if grid.rows]


def defined_changes(combination: Comparison, manner: str) -> list[Change]:
    """The measures, the success rate first. A measure that is not defined under either reward is left out."""
    changes = [change for change in combination.changes_of(manner) if (change.baseline, change.proposed) != (None,) * 2]
    return sorted(changes, key=lambda change: change.name != SUCCESS)


def failed_changes(combination: Comparison, manner: str) -> list[Change]:
    """The measures whose metric failed for every seed. They stand below the others, with the reason."""
    defined = {change.name for change in defined_changes(combination, manner)}
    return [change for change in combination.changes_of(manner) if change.reason and change.name not in defined]


def behaviour_row(change: Change, text: Text | None = None) -> BehaviourRow:
    """The row of a measure. If its metric failed for all seeds, the reason stands in place of the values.

    Args:
        change: The values of the measure.
        text: How its values are written: `percentage`, or as any other number; by default as the values look.
    """
    text = text or _text_of(change)
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
        format_p(change.corrected),
        change.direction,
    )


def value_text(change: Change, value: float) -> str:
    """A value of a measure, written as the measure's means are."""
    return _text_of(change)(value)


def along_grid(combination: Comparison) -> Grid:
    """What would have been said of the robot at each evaluation, the last one after the trainings."""
    headings = ("", "success: baseline", "proposed", "difference", "the robot")
    manner = combination.own_manner
    moments = [*combination.along, StepChange(combination.group.steps, combination.changes_of(manner))]
    rows = [_moment_row(combination, moment) for moment in moments] if combination.along else []
    return Grid(headings, rows, [], f"Along the budget of training, {manner}")


def seeds_grid(combination: Comparison) -> Grid:
    """What single seeds say where a mean may hide it, in the manner that decides."""
    headings = ("over seeds", "middle half: baseline", "proposed", "chance that a run is better")
    rows: list[tuple[str, ...]] = []
    for change in combination.changes_of(combination.manner):
        if change.improvement is not None:
            text = _text_of(change)
            rows.append((_name(change), *map(text, change.middles), f"{change.improvement:.0%}"))
    return Grid(headings, rows, [])


def _grid(combination: Comparison, manner: str) -> Grid:
    ordered = defined_changes(combination, manner)
    notes = [_note(change) for change in ordered if change.left_out]
    rows = [tuple(behaviour_row(change)) for change in (*ordered, *failed_changes(combination, manner))]
    return Grid(HEADINGS, rows, notes, _title(combination, manner))


def _note(change: Change) -> str:
    why = f" ({shortened(change.reason, SHOWN)})" if change.reason else ""
    name, compared = change.name.replace("_", " "), count_seeds(change.seeds)
    return f"{name}: {compared} compared, {change.left_out} without a value{why}"


def _title(combination: Comparison, manner: str) -> str:
    """How the policies acted, and how many episodes were seen."""
    episodes = combination.episodes.get(manner)
    if episodes is None:
        return f"Behaviour {manner}"
    seen = f"{episodes:,} episode{'s' * (episodes != 1)}"
    # Trainings need not have the same number of episodes.
    if manner == TRAINING:
        return f"Behaviour {manner}, {seen} or more per seed"
    return f"Behaviour of the trained policies, {manner}, {seen} per seed"


def _moment_row(combination: Comparison, moment: StepChange) -> tuple[str, ...]:
    """The row of an evaluation, with the answer that would have been given after it."""
    success = next((change for change in moment.changes if change.name == SUCCESS), None)
    told = behaviour_row(success) if success else None
    values = (told.baseline, told.proposed, told.difference) if told else (NOTHING,) * 3
    return (f"after {moment.steps:,} steps", *values, combination.headline_at(moment).answer.value)


def _name(change: Change) -> str:
    name, unit = change.measure.title or change.name.replace("_", " "), change.measure.unit
    return f"{name} [{unit}]" if unit and unit not in name.split() else name


def _text_of(change: Change) -> Text:
    """The function that writes values of a measure: as a percentage if it is a share, else as a number."""
    values = (change.baseline, change.proposed, change.random)
    is_share = not change.measure.unit and all(value is None or 0.0 <= value <= 1.0 for value in values)
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
