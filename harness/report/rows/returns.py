"""What was paid, as text: returns under every reward, the pay of an episode, what each term paid."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from harness.errors import sentence
from harness.eta.curve import Kind
from harness.eta.headline import format_number, is_drawable, signed, value_text
from harness.eta.index import NOTHING, Estimate
from harness.eta.splits import BB, KK, Splits
from harness.registry.choice import parse
from harness.report.rows import Grid
from harness.report.rows.ratios import (
    index_grid,
    lines_of,
    split_grids,
    sum_grid,
    value_rows,
)
from harness.results import Results
from harness.results.comparison import Comparison
from harness.results.results import ReturnMatrix
from harness.results.trainings import TermsPaid
from harness.reward.terms import paid_twice_text

EXPLANATION = (
    "A row is a reward that pays, a column the reward that taught the policies. The number is the return of an "
    "episode, as a mean over episodes and seeds. Compare within a row: down a column the scale changes, not the "
    "behaviour."
)
SCORED_BY = "evaluation return, scored by"
PAY = "The pay of an episode"
READING = (
    "The pay of an episode is its return, as a mean over episodes, then over seeds. Each training is paid by its own "
    "reward, baseline or proposed. Its change has two parts. The ruler is rescaling alone: both rewards pay the same "
    "episodes. For the behaviour one reward pays the episodes of both."
)


def returns_grid(comparison: Comparison) -> Grid:
    """The pay of an episode of either training, and what its change is made of; no rows if it is not known."""
    rows: list[tuple[str, ...]] = []
    for manner, split in comparison.number.returns.items():
        parts = (split.total.change, split.total.ruler, split.total.behaviour)
        rows += value_rows(manner, (split.returns[BB], split.returns[KK], *parts), with_points=True)
    notes = [f"{manner}: {NOTHING}: {reason}" for manner, reason in comparison.number.missing.items()]
    reasons = dict.fromkeys(
        note
        for split in comparison.number.returns.values()
        for it in (split.returns[BB], split.total.ruler)
        for note in it.notes
    )
    headings = ("", "baseline", "proposed", "difference", "of it ruler", "of it behaviour")
    return Grid(headings, rows, [*notes, *reasons], PAY)


def return_grid(matrix: ReturnMatrix) -> Grid:
    """A row per scoring reward, each interval under its mean; a column per training."""
    rows: list[tuple[str, ...]] = []
    for name, row in _named(matrix).items():
        rows += value_rows(name, [row[label] for label in matrix.trained_with], with_points=True)
    scored = f"return {matrix.manner}, scored by" if matrix.manner else SCORED_BY
    return Grid((scored, *matrix.trained_with), rows, _notes(matrix))


def matrix_title(matrix: ReturnMatrix) -> str:
    """Which trainings a matrix is about."""
    return f"{matrix.group.title}, {matrix.manner}" if matrix.manner else matrix.group.title


def _named(matrix: ReturnMatrix) -> dict[str, Mapping[str, Estimate]]:
    events = {"events, paid on top": matrix.events} if matrix.events else {}
    return {**matrix.returns, **events}


def _notes(matrix: ReturnMatrix) -> list[str]:
    """One line for each remark, with the rows that it holds for if not for all."""
    rows = _named(matrix)
    return lines_of([(name, note) for name, row in rows.items() for note in dict.fromkeys(_notes_of(row))], len(rows))


def _notes_of(row: Mapping[str, Estimate]) -> Iterator[str]:
    for mean in row.values():
        yield from (f"{NOTHING}: {note}" if mean.value is None else note for note in mean.notes)


ALL = 0.1
"""Where the behaviour's share of a change is smaller than this, the change is nearly all rescaling."""


class PayPart(NamedTuple):
    """A part of the change of pay."""

    name: str
    """``ruler`` or ``behaviour``."""
    text: str
    """Its value, such as ``× 1.54`` or ``+386``."""
    size: float
    """Its logarithm, or its value: what its bar shows. Sizes of one change add up to all of it."""


def pay_parts(comparison: Comparison) -> tuple[PayPart, ...]:
    """What the change is made of that `Comparison.pay_sentence` tells: the ruler and the behaviour; empty without."""
    pay, splits = comparison.number.pay, comparison.number.splits
    for ratio in [pay.ratio] if pay else [splits["eta_P"], splits["eta_N"]]:
        if all(map(is_drawable, (ratio.eta, ratio.ruler, ratio.behaviour))):
            factors = (("ruler", ratio.ruler), ("behaviour", ratio.behaviour))
            return tuple(PayPart(name, f"× {value_text(it)}", math.log(it.value or 1.0)) for name, it in factors)
    if pay is None or pay.has_ratio:
        return ()
    amounts = (("ruler", pay.total.ruler.value), ("behaviour", pay.total.behaviour.value))
    return tuple(PayPart(name, signed(it), it) for name, it in amounts if it is not None)


def is_ruler(parts: Sequence[PayPart]) -> bool:
    """Whether the behaviour's part is so small that the change is nearly all ruler."""
    return bool(parts) and abs(parts[-1].size) < ALL * abs(sum(part.size for part in parts))


INDICES = "The note's eta_N and eta_P"


def splits_of(comparison: Comparison) -> Splits:
    """The eta of the mean return in the manner that decides, then those of both indices, as far as they are split."""
    main = {} if comparison.number.main is None else {"eta": comparison.number.main.ratio}
    return {**main, **(comparison.number.index_splits if comparison.number.is_split else {})}


def number_grids(comparison: Comparison, kind: Kind) -> list[Grid]:
    """The tables of ratios and indices, in the order in which they are read.

    Args:
        comparison: The comparison.
        kind: Of the curves that the indices are read from.
    """
    number, grids = comparison.number, list[Grid]()
    returned = {f"pay, {manner}": split.ratio for manner, split in number.returns.items()}
    indices = number.index_splits or number.splits if number.has_pay else {}
    for name, found in ((PAY, returned), (INDICES, indices)):
        grids += [replace(grid, title=f"{name}: {grid.title}") for grid in split_grids(found)]
    if number.decomposition is not None:
        grids += [sum_grid(number.decomposition.total), index_grid(number.decomposition, kind)]
    return grids


TERMS_TITLE = "What each term paid"
COLUMNS = ("start", "end", "evaluation", "others", "random", "behaviour", "ruler")
ALWAYS = COLUMNS[:2]
"""Columns that stand there without a value too."""


def terms_of(results: Results, comparison: Comparison) -> list[TermsPaid]:
    """What the terms of the compared rewards paid: of the proposed one, and in the first comparison of the baseline."""
    names = [comparison.proposed, *([comparison.baseline] if comparison is results.combinations[0] else [])]
    there = [it for it in results.terms if it.group == comparison.group and it.reward in names]
    return sorted(there, key=lambda it: names.index(it.reward))


def terms_grid(found: TermsPaid) -> Grid:
    """A row for each term, its interval below it; below the table what to say of them."""
    terms = found.terms
    shown = [name for name in COLUMNS if name in ALWAYS or any(_is_known(getattr(term, name)) for term in terms)]
    rows = [row for term in terms for row in value_rows(term.name, [getattr(term, name) for name in shown])]
    headings = (f"with {found.baseline}" if name == "others" else name for name in shown)
    return Grid(("an episode", *headings), rows, list(_term_notes(found)), f"{TERMS_TITLE}: {found.reward}")


def never_texts(results: Results) -> list[str]:
    """A sentence for each term that never paid; where there are several places, each says its own."""
    several = len({it.group for it in results.terms}) > 1
    return [
        f"{f'{it.group.title}, ' if several else ''}{it.reward}: {text}" for it in results.terms for text in _never(it)
    ]


def changed_text(found: TermsPaid) -> str:
    """Which term changed most; empty where there is one term, or none changed."""
    most = found.most_changed
    if most is None or len(found.terms) < 2:
        return ""
    if not found.is_compared:
        start, end = format_number(most.start.value), format_number(most.end.value)
        return f"`{most.name}` changed most: {start} an episode at the start of the trainings, {end} at their end."
    own, others = format_number(most.final.value), format_number(most.others.value)
    where = "of the evaluations" if most.evaluation.value is not None else "at the end of the trainings"
    return f"`{most.name}` differs most: it pays {own} an episode {where}, and {others} with {found.baseline}."


def _is_known(value: Estimate | float | None) -> bool:
    return (value.value if isinstance(value, Estimate) else value) is not None


def _term_notes(found: TermsPaid) -> Iterator[str]:
    yield from filter(None, [changed_text(found)])
    yield from _never(found)
    if found.is_compared:
        yield (
            f"Behaviour is what the term pays in the end minus what it pays the trainings with {found.baseline}. Over "
            f"all terms it adds up to the behaviour part on one of the two paths: {found.path}."
        )
    if any(it.ruler.value is not None for it in found.terms):
        yield f"Ruler is what the term pays the episodes of {found.baseline} minus what its own term of that name pays."
    if found.missing:
        yield f"With {found.baseline} n/a: {found.missing}"


def _never(found: TermsPaid) -> Iterator[str]:
    weights = parse(found.reward)[1]
    for term in found.terms:
        if term.never:
            off = ": its weight is 0" if weights.get(term.name) in ("0", "-0") else ""
            later = " of training, only in the evaluations" if term.evaluation.value else ""
            yield f"`{term.name}` never paid in {found.steps:,} steps{later}{off}."
    if found.twice:
        yield f"{sentence(paid_twice_text(found.twice, found.steps))}."


class Payoffs(NamedTuple):
    """What one reward pays the scripted policies of one robot and task."""

    verdict: tuple[str, ...]
    """Whether reaching the target pays best, in sentences; or why that is not known."""
    returns: Mapping[str, float]
    """Mean return of an episode, event terms included, by script; empty where it is not known."""
    success: Mapping[str, float]
    """Share of the episodes that end at the target, by script."""


Audits = Mapping[tuple[str, str, str], Payoffs]
"""By robot, label of the task and label of the reward."""


class Story(NamedTuple):
    """What both rewards pay for, and what the robot did under them."""

    sentences: tuple[str, ...]
    grid: Grid


def payoff_story(comparison: Comparison, audits: Audits) -> Story | None:
    """The story of a comparison; None if no audit was made."""
    group = comparison.group
    labels = list(dict.fromkeys((comparison.baseline, comparison.proposed)))
    found = {label: audits[key] for label in labels if (key := (group.robot, group.task.label, label)) in audits}
    if not found:
        return None
    sentences = [
        f"{label}: {' '.join(payoffs.verdict)}{_done(comparison, label, payoffs)}" for label, payoffs in found.items()
    ]
    return Story(tuple(sentences), _grid(found))


def _done(comparison: Comparison, label: str, payoffs: Payoffs) -> str:
    """What the robot did that was trained with this reward."""
    changes = {change.name: change for change in comparison.measured.changes_of(comparison.manner)}
    over, missed = (changes.get(name) for name in ("timeouts", "closest_distance"))
    if not payoffs.returns or over is None:
        return ""
    is_baseline = label == comparison.baseline
    share = over.baseline if is_baseline else over.proposed
    if share is None:
        return ""
    told = f" The robot that learned from it ran out of time in {share:.1%} of the episodes"
    nearest = missed and (missed.baseline if is_baseline else missed.proposed)
    near = f"; on average it came as near as {nearest:.3g} {missed.measure.unit}" if missed and nearest else ""
    return f"{told}{near}."


def _grid(found: Mapping[str, Payoffs]) -> Grid:
    """A row for each script. The script that earns most under the last reward comes first."""
    *_, last = found.values()
    scripts: Sequence[str] = sorted(last.returns, key=lambda script: -last.returns[script])
    rows = [
        (
            script,
            f"{last.success[script]:.0%}",
            *(format_number(payoffs.returns[script]) if payoffs.returns else NOTHING for payoffs in found.values()),
        )
        for script in scripts
    ]
    headings = ("scripted policy", "success", *(f"return under {label}" for label in found))
    return Grid(headings, rows, [])
