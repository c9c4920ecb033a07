"""All comparisons of an experiment at a glance: a map of answers, and a table to sort and filter."""

import csv
from collections.abc import Sequence
from io import StringIO
from typing import Any, NamedTuple

import numpy as np

from harness.eta.behaviour_change import Change
from harness.eta.headline import SHORT, Answer
from harness.eta.index import NOTHING, Ratio
from harness.eta.scored_sums import BB, KK
from harness.report.answers import badge_of, symbol_of, word_of
from harness.report.apart import tell_apart
from harness.report.rows.behaviour import behaviour_row, percentage, text_of
from harness.report.rows.ratios import format_number, interval_text, ratio_text
from harness.results.comparison import Comparison, Group
from harness.text import visible


class Sortable(NamedTuple):
    """A value of the table."""

    text: str
    detail: str
    """A smaller text beside the value: its interval."""
    key: str
    """The key to sort by. It is empty if there is no value; such rows come last."""


NONE = Sortable(NOTHING, "", "")
"""In place of a value that is not known."""


class Entry(NamedTuple):
    """One comparison."""

    anchor: str
    place: str
    proposed: str
    answer: str
    badge: str
    symbol: str
    difference: str
    """Difference of the measure that decides, of a share in percentage points; empty if it is not known."""
    values: tuple[Sortable, ...]


class Matrix(NamedTuple):
    """Every comparison by its place and its proposed reward."""

    shared: str
    """What is the same in all."""
    places: list[str]
    rows: list[tuple[str, list[Entry | None]]]
    """A row for each proposed reward, with an entry per place."""
    entries: list[Entry]
    counts: list[tuple[str, str, int]]
    """How many comparisons have each answer: its badge, its words, the number."""
    headings: tuple[str, ...]
    """The headings of the values of an entry."""
    told: str
    """What the map shows in each place, in a sentence."""


FORMULAS = ("=", "+", "-", "@")
"""Characters with which a formula begins in a spreadsheet."""
KINDS = ("simulator", "algorithm", "robot", "task")
COLUMNS = (
    *(*KINDS, "steps", "baseline", "proposed", "seeds", "baseline_trainings", "proposed_trainings", "answer"),
    *("eta_N", "eta_N_low", "eta_N_high", "eta_P", "eta_P_low", "eta_P_high"),
    *("success_baseline", "success_proposed", "success_difference", "success_low", "success_high"),
)
"""The columns of the table as a file."""


def matrix_of(combinations: Sequence[Comparison]) -> Matrix:
    """The map and the table."""
    baselines = dict.fromkeys(it.baseline for it in combinations)
    described = [
        (*_describe(it.group), *([f"against {it.baseline}"] if len(baselines) > 1 else [])) for it in combinations
    ]
    apart, kinds = tell_apart(described), _kinds(combinations)
    entries = [
        _entry(number, place, comparison, kinds)
        for number, (place, comparison) in enumerate(zip(apart.names, combinations, strict=True), 1)
    ]
    places = list(dict.fromkeys(apart.names))
    rewards = list(dict.fromkeys(entry.proposed for entry in entries))
    found = {(entry.proposed, entry.place): entry for entry in entries}
    rows = [(reward, [found.get((reward, place)) for place in places]) for reward in rewards]
    counts = [
        (badge_of(answer), word_of(answer), sum(entry.badge == badge_of(answer) for entry in entries))
        for answer in Answer
    ]
    shared = apart.shared if len(baselines) > 1 else f"{apart.shared}, against {''.join(baselines)}"
    name, unit = kinds.measure, " [pp]" if kinds.is_share else ""
    headings = (*kinds.numbers, f"{name}, baseline", f"{name}, proposed", f"difference{unit}")
    told = f"{name.capitalize()}, proposed - baseline{', in percentage points' if kinds.is_share else ''}."
    return Matrix(shared, places, rows, entries, [count for count in counts if count[2]], headings, told)


class _Kinds(NamedTuple):
    """Which numbers there are in some comparison."""

    measure: str
    is_share: bool
    numbers: tuple[str, ...]
    """Their headings: of the pay of an episode, or else of both indices."""


def _kinds(combinations: Sequence[Comparison]) -> _Kinds:
    decisive = [it.decisive for it in combinations if it.decisive is not None]
    names = dict.fromkeys(SHORT.get(it.name, it.name.replace("_", " ")) for it in decisive)
    pays, is_share = [it.number.pay for it in combinations], all(text_of(it.measure) is percentage for it in decisive)
    has_ratios = any(pay.has_ratio for pay in pays if pay is not None)
    numbers = ("pay, baseline", "pay, proposed", "pay, ratio")[: 2 + has_ratios] if any(pays) else ("eta_N", "eta_P")
    return _Kinds(" / ".join(names) or "behaviour", is_share, numbers)


def comparisons_csv(combinations: Sequence[Comparison]) -> str:
    """A row per comparison, numbers as exact as they are known."""
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for comparison in combinations:
        success, number = comparison.decisive, comparison.number
        ratios = [end for eta in (number.eta_n, number.eta_p) for end in (eta.value, eta.low, eta.high)]
        shares = (success and getattr(success, it) for it in ("baseline", "proposed", "difference", "low", "high"))
        labels = comparison.group.labels
        described = (*(labels.get(kind, "") for kind in KINDS), comparison.group.steps, *comparison.names)
        seeds = (len(comparison.seeds), *comparison.counts)
        told = (*described, *seeds, comparison.headline.answer.value, *ratios, *shares)
        writer.writerow([plain_text(value) for value in told])
    return text.getvalue()


def plain_text(value: Any) -> str:
    """A value as text. Python's text of a float is the shortest that gives the same float back."""
    if value is None:
        return ""
    if isinstance(value, str):
        return _text(value)
    return repr(float(value) + 0.0) if isinstance(value, float | np.floating) else str(value)


def _text(value: str) -> str:
    """A text that a spreadsheet does not compute: an apostrophe stands before it if it begins like a formula."""
    text = visible(value)
    return f"'{text}" if text.lstrip().startswith(FORMULAS) else text


def _describe(group: Group) -> tuple[str, ...]:
    evaluated = [f"evaluated {group.manner}"] if group.evaluation_episodes else []
    return (*group.shown.values(), f"{group.steps:,} steps", *evaluated)


def _entry(number: int, place: str, comparison: Comparison, kinds: _Kinds) -> Entry:
    answer, change = comparison.headline.answer, comparison.decisive
    difference = "" if change is None or change.difference is None else _points(change)
    numbers = _numbers(comparison)
    return Entry(
        f"combination-{number}",
        place,
        f"{comparison.proposed} (A/A)" if comparison.is_control else comparison.proposed,
        word_of(answer),
        badge_of(answer),
        symbol_of(answer),
        difference,
        (*(numbers.get(it, NONE) for it in kinds.numbers), *_measured(change)),
    )


def _points(change: Change) -> str:
    """The difference of a measure; of a share in percentage points."""
    difference = change.difference or 0.0
    return f"{100 * difference:+.1f}" if text_of(change.measure) is percentage else f"{difference:+.3g}"


def _numbers(comparison: Comparison) -> dict[str, Sortable]:
    """By heading, the numbers that are known."""
    number, pay = comparison.number, comparison.number.pay
    found = {"eta_N": _ratio(number.eta_n), "eta_P": _ratio(number.eta_p)}
    if pay is None:
        return found
    means = {"pay, baseline": pay.returns[BB].mean, "pay, proposed": pay.returns[KK].mean}
    sides = {name: Sortable(format_number(mean), "", _key(mean)) for name, mean in means.items()}
    return {**found, **sides, "pay, ratio": _ratio(pay.ratio.eta)}


def _ratio(eta: Ratio) -> Sortable:
    return Sortable(ratio_text(eta), interval_text(eta, missing=""), _key(eta.value))


def _measured(change: Change | None) -> tuple[Sortable, ...]:
    if change is None:
        return (NONE,) * 3
    told = behaviour_row(change)
    sides = ((told.baseline, change.baseline), (told.proposed, change.proposed))
    values = [Sortable(text, "", _key(value)) for text, value in sides]
    if change.difference is None:
        return (*values, NONE)
    interval = "" if change.low is None else told.difference.removesuffix(" pp")
    return (*values, Sortable(_points(change), interval, _key(change.difference)))


def _key(value: float | None) -> str:
    return "" if value is None else repr(value)
