"""All comparisons of an experiment at a glance: a map of answers, and a table to sort and filter."""

import csv
from collections.abc import Sequence
from io import StringIO
from typing import NamedTuple

from harness.eta.behaviour_change import Change
from harness.eta.headline import Answer
from harness.report.apart import tell_apart
from harness.report.rows.behaviour import behaviour_row
from harness.report.rows.comparison import answer_text, interval_text, ratio_text
from harness.report.summary.cells import plain_text
from harness.results.comparison import Comparison, Group
from harness.results.overview import NOTHING

SYMBOLS = {Answer.HELPS: "▲", Answer.HURTS: "▼", Answer.NO_DIFFERENCE: "=", Answer.CANNOT_TELL: "?"}
"""Symbols that tell the answers apart without colour."""


class Sortable(NamedTuple):
    """A value of the table."""

    text: str
    detail: str
    """A smaller text beside the value: its interval."""
    key: str
    """The key to sort by. It is empty if there is no value; such rows come last."""


class Entry(NamedTuple):
    """One comparison."""

    anchor: str
    place: str
    proposed: str
    answer: str
    badge: str
    symbol: str
    difference: str
    """Difference of the success rate, in percentage points; empty if it is not known."""
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


HEADINGS = ("eta_N", "eta_P", "success, baseline", "success, proposed", "difference [pp]")


COLUMNS = (
    *("simulator", "algorithm", "robot", "task", "steps", "baseline", "proposed", "seeds", "answer"),
    *("eta_N", "eta_N_low", "eta_N_high", "eta_P", "eta_P_low", "eta_P_high"),
    *("success_baseline", "success_proposed", "success_difference", "success_low", "success_high"),
)
"""The columns of the table as a file."""


def badge_of(answer: Answer) -> str:
    """The class that colours an answer."""
    return answer.name.lower().replace("_", "-")


def anchor_of(place: int) -> str:
    """The anchor of a comparison on the page, by its place, counted from 0."""
    return f"combination-{place + 1}"


def matrix_of(combinations: Sequence[Comparison]) -> Matrix:
    """The map and the table."""
    described = [_describe(combination.group) for combination in combinations]
    apart = tell_apart(described)
    entries = [
        _entry(number, place, combination)
        for number, (place, combination) in enumerate(zip(apart.names, combinations, strict=True))
    ]
    groups = [combination.group for combination in combinations]
    places = dict(zip(groups, apart.names, strict=True))
    rewards = list(dict.fromkeys(entry.proposed for entry in entries))
    found = {(entry.proposed, group): entry for entry, group in zip(entries, groups, strict=True)}
    rows = [(reward, [found.get((reward, group)) for group in places]) for reward in rewards]
    counts = [
        (badge_of(answer), answer.value.upper(), sum(entry.badge == badge_of(answer) for entry in entries))
        for answer in Answer
    ]
    return Matrix(apart.shared, list(places.values()), rows, entries, [count for count in counts if count[2]])


def comparisons_csv(combinations: Sequence[Comparison]) -> str:
    """A row per comparison, numbers as exact as they are known."""
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for combination in combinations:
        ratios = [end for eta in (combination.eta_n, combination.eta_p) for end in (eta.value, eta.low, eta.high)]
        success = combination.decisive
        shares = (
            (success.baseline, success.proposed, success.difference, success.low, success.high)
            if success
            else (None,) * 5
        )
        described = (*combination.group.labels.values(), combination.group.steps, *combination.names)
        told = (*described, len(combination.seeds), combination.headline.answer.value, *ratios, *shares)
        writer.writerow([plain_text(value) for value in told])
    return text.getvalue()


def _describe(group: Group) -> tuple[str, ...]:
    return (*group.labels.values(), f"{group.steps:,} steps", f"evaluated {group.manner}")


def _entry(number: int, place: str, combination: Comparison) -> Entry:
    headline, success = combination.headline, combination.decisive
    values = [
        Sortable(ratio_text(eta), interval_text(eta, missing=""), "" if eta.value is None else repr(eta.value))
        for eta in (combination.eta_n, combination.eta_p)
    ]
    return Entry(
        anchor_of(number),
        place,
        f"{combination.proposed} (A/A)" if combination.is_control else combination.proposed,
        answer_text(headline),
        badge_of(headline.answer),
        SYMBOLS[headline.answer],
        "" if success is None or success.difference is None else f"{100 * success.difference:+.1f}",
        (*values, *_shares(success)),
    )


def _shares(success: Change | None) -> tuple[Sortable, ...]:
    if success is None:
        return (Sortable(NOTHING, "", ""),) * 3
    told = behaviour_row(success)
    sides = ((told.baseline, success.baseline), (told.proposed, success.proposed))
    shares = [Sortable(text, "", "" if value is None else repr(value)) for text, value in sides]
    if success.difference is None:
        return (*shares, Sortable(NOTHING, "", ""))
    interval = "" if success.low is None else told.difference.removesuffix(" pp")
    return (*shares, Sortable(f"{100 * success.difference:+.1f}", interval, repr(success.difference)))
