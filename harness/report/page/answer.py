"""The first screen: for each reward the answer, what decided it, and the pay beside it."""

import csv
import re
from collections.abc import Sequence
from io import StringIO
from typing import Any, NamedTuple

import numpy as np

from harness.eta.amounts import difference_text, listed, same_text, short_seen_text, short_values, trainings_text
from harness.eta.behaviour_change import Change
from harness.eta.headline import (
    SHORT,
    TIME,
    Answer,
    name_of,
    name_with_article,
    percentage,
)
from harness.eta.judgement import OPEN, Verdict
from harness.eta.power import range_text
from harness.eta.splits import Names
from harness.eta.swaps import luck_text
from harness.eta.verdict.ruling import Ruling
from harness.report.figures.split import draw_interval, draw_part, draw_trainings
from harness.report.rows import Grid
from harness.report.rows.comparison import (
    BETWEEN,
    LEGEND,
    SYMBOLS,
    badge_of,
    beside_answer,
    text_of,
    word_of,
)
from harness.report.rows.returns import is_ruler, pay_parts
from harness.results.comparison import Comparison, pools_of
from harness.results.overview import group_name, overview_of, overview_rows, varying_kinds
from harness.results.pool import Pool
from harness.text import visible


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


class Matrix(NamedTuple):
    """Every comparison by its place and its proposed reward."""

    places: list[str]
    rows: list[tuple[str, list[Entry | None]]]
    """A row for each proposed reward, with an entry per place."""
    entries: list[Entry]
    counts: list[tuple[str, str, int]]
    """How many comparisons have each answer: its badge, its words, the number."""
    table: Grid
    """A row for each entry, as a terminal shows it."""
    told: str
    """What the map shows in each place."""


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
    varying, several = varying_kinds(combinations), len({it.baseline for it in combinations}) > 1
    named = ((group_name(it, varying), f"against {it.baseline}" * several) for it in combinations)
    names = [BETWEEN.join(filter(None, it)) for it in named]
    entries = [_entry(number, *it) for number, it in enumerate(zip(names, combinations, strict=True), 1)]
    places = list(dict.fromkeys(names))
    rewards = list(dict.fromkeys(entry.proposed for entry in entries))
    found = {(entry.proposed, entry.place): entry for entry in entries}
    rows = [(reward, [found.get((reward, place)) for place in places]) for reward in rewards]
    counts = [
        (badge_of(answer), word_of(answer), sum(entry.badge == badge_of(answer) for entry in entries))
        for answer in Answer
    ]
    decisive = [it.decisive for it in combinations if it.decisive is not None]
    is_share = bool(decisive) and all(text_of(it.measure) is percentage for it in decisive)
    measures = dict.fromkeys(SHORT.get(it.name, it.name.replace("_", " ")) for it in decisive)
    name = " / ".join(measures) or "behaviour"
    told = f"{name.capitalize()}, proposed - baseline{', in percentage points' if is_share else ''}. {LEGEND}."
    headings, lines = (overview_of(combinations).headings, overview_rows(combinations)) if combinations else ((), [])
    return Matrix(places, rows, entries, [count for count in counts if count[2]], Grid(headings, lines, []), told)


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


def _entry(number: int, place: str, comparison: Comparison) -> Entry:
    answer, change = comparison.headline.answer, comparison.decisive
    difference = "" if change is None or change.difference is None else _points(change)
    return Entry(
        f"combination-{number}",
        place,
        f"{comparison.proposed} (A/A)" if comparison.is_control else comparison.proposed,
        word_of(answer),
        badge_of(answer),
        SYMBOLS[answer],
        difference,
    )


def _points(change: Change) -> str:
    """The difference of a measure; of a share in percentage points."""
    difference = change.difference or 0.0
    return f"{100 * difference:+.1f}" if text_of(change.measure) is percentage else f"{difference:+.3g}"


class Row(NamedTuple):
    """A line of a card: a name, a picture, a value."""

    name: str
    note: str
    """Smaller, below the name."""
    figure: str
    """HTML; empty where there is nothing to draw."""
    value: str
    kind: str = ""
    """The class of the name's colour; empty for none."""


class Card(NamedTuple):
    """The answer about a reward."""

    name: str
    answer: str
    badge: str
    lead: str
    """The answer in a sentence or two."""
    rows: tuple[Row, ...]
    """One for each measure that decides."""
    sure: str
    """What decided, and how sure it is; where nothing did, why, and what would tell."""
    seen: str = ""
    """What stands before the answer: the differences, and how many trainings failed."""
    pay: str = ""
    """How much more an episode is paid, in the comparison's sentence without its intervals."""
    is_ruler: bool = False
    """Whether nearly all of that is the ruler."""
    parts: tuple[Row, ...] = ()
    """The ruler and the behaviour."""
    beside: tuple[str, ...] = ()
    """What else has to be known at once, a sentence or two each."""


def card_of(comparison: Comparison, name: str) -> Card:
    """The card of a comparison.

    Args:
        comparison: The comparison.
        name: What it is called on the page.
    """
    names, changes, parts = comparison.names, comparison.decisive_changes, pay_parts(comparison)
    card = pool_card(comparison)._replace(name=name, beside=tuple(beside_answer(comparison)))
    if changes and comparison.verdict.is_same:
        rows = (it._replace(figure="", value=short_values(of)[1]) for it, of in zip(card.rows, changes, strict=True))
        card = card._replace(seen=same_text(names, changes), rows=tuple(rows))
    first = next((it for it in changes if name_of(it) == card.rows[0].name), None)
    if first is not None:
        card = card._replace(rows=(card.rows[0], *_trainings(names, first), *card.rows[1:]))
    farthest = max((abs(part.size) for part in parts), default=0.0)
    drawn = (Row(it.name, NOTES[it.name], draw_part(it.size, farthest, it.name), it.text, it.name) for it in parts)
    return card._replace(pay=ENDS.sub("", comparison.pay_sentence), is_ruler=is_ruler(parts), parts=tuple(drawn))


def pool_card(found: Pool | Comparison) -> Card:
    """The card of a reward over all places; of one place without what stands there alone."""
    verdict, answer, by = found.verdict, found.headline.answer, list[int]()
    if answer is Answer.MIXED:
        by = verdict.passing
    elif found.headline.decided_by:
        by = [verdict.decider]
    changes, names = verdict.deciding, verdict.names
    order = [*by, *(at for at in range(len(changes)) if at not in by)]
    rows = tuple(_row(changes[at], at, verdict.ruling, at in by) for at in order)
    seen, sure = (short_seen_text(names, changes, verdict.asides), _sure(verdict, by)) if changes else ("", "")
    return Card(names.proposed, word_of(answer), badge_of(answer), found.lead, rows, sure, seen)


def pool_cards(comparisons: Sequence[Comparison]) -> list[Card]:
    """The cards of the answers over all places, each once; none where there is one place."""
    return [pool_card(pool) for pool in pools_of(comparisons)]


def _sure(verdict: Verdict, by: Sequence[int]) -> str:
    """What decided, and how sure it is; where nothing did, why, and what would tell."""
    if verdict.answer in OPEN:
        luck = [luck_text(verdict.ruling.of_measures[at]) for at in by]
        return " ".join(filter(None, [*luck, *verdict.why, verdict.needed_text("of each reward")]))
    if by:
        first, measures = verdict.deciding[0], listed([name_with_article(verdict.deciding[at]) for at in by])
        of = trainings_text(verdict.names, first.counts, first.without)
        return f"Decided by {measures}, from {of}. {verdict.sure}"
    return verdict.reserve


def _row(change: Change, at: int, ruling: Ruling, decides: bool) -> Row:
    direction = "" if not (ruling.is_decided and ruling.passes(at)) else "better" if ruling.signs[at] > 0 else "worse"
    figure = draw_interval(change, direction)
    value = difference_text(change, 2).partition(" ")[0] if change.is_relative else " -> ".join(short_values(change))
    notes = ["decides"] * decides + [FAILURE] * (change.name == TIME)
    return Row(name_of(change), "; ".join(notes), figure, value)


def _trainings(names: Names, change: Change) -> list[Row]:
    """Both rewards' trainings one by one, by the measure that decides, or is asked first."""
    known = [*change.values[0], *change.values[1]]
    rows = []
    for name, who, values in zip(names, ("baseline", "proposed"), change.values, strict=True):
        figure = draw_trainings(values, (min(known), max(known)), change.measure.better, who)
        ends = list(dict.fromkeys(map(text_of(change.measure), (min(values), max(values))))) if values else []
        unit = change.measure.unit if values else ""
        rows.append(Row(name, "each training", figure, f"{' to '.join(ends)} {unit}".rstrip(), who))
    return rows


FAILURE = "a failure counts as the whole time limit"
"""What is said beside the time to the target."""
ENDS = re.compile(r" \[[-+.,\de]+, [-+.,\de]+\]")
"""An interval: on the first screen stand those of the measures alone."""
NOTES = {"ruler": "same episodes, other reward", "behaviour": "other episodes, same reward"}
"""What the parts of the pay are."""


def groups_of(cards: Sequence[Card], comparisons: Sequence[Comparison], shown: int = 0) -> list[dict[str, Any]]:
    """The comparisons of a page by their answer, with a sentence for all that have none in common.

    Args:
        cards: The card of each comparison.
        comparisons: The comparisons.
        shown: How many of them stand there in full, and so in no group.
    """
    groups: dict[str, list[int]] = {}
    for number, card in enumerate(cards[shown:], shown):
        groups.setdefault(card.badge, []).append(number)
    return [
        {
            "badge": badge,
            "answer": cards[groups[badge][0]].answer,
            "places": groups[badge],
            "told": _told([comparisons[number] for number in groups[badge]]),
        }
        for badge in map(badge_of, Answer)
        if badge in groups
    ]


def _told(comparisons: Sequence[Comparison]) -> str:
    """What holds for all comparisons without an answer, in a paragraph; empty for others."""
    found = [it.headline for it in comparisons]
    if len(comparisons) < 2 or any(it.answer is not Answer.CANNOT_TELL for it in found):
        return ""
    needed = [it.seeds_to_decide for it in found if it.seeds_to_decide is not None]
    if all(it.answer.ruling is not None and it.answer.ruling.is_held for it in comparisons):
        return "A single place is told only where the answer over all is."
    if not needed:
        return "Nothing decides these comparisons."
    between = range_text((min(it[0] for it in needed), max(it[1] for it in needed)))
    some = "" if len(needed) == len(found) else f" For {len(found) - len(needed)} of them no number can be told."
    return (
        f"Their trainings are not enough. {between} of each reward would tell, under the condition that each names "
        f"below.{some}"
    )
