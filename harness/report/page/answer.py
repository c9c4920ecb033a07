"""The first screen: for each reward the answer, what decided it, and the pay beside it."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from harness.eta.headline import Answer, Compared, Headline
from harness.eta.lead import at_most_text, name_of, short_values
from harness.eta.verdict.ruling import Ruling
from harness.report.answers import badge_of, word_of
from harness.report.figures.forest import draw_interval, draw_part
from harness.report.rows.comparison import beside_answer
from harness.report.rows.pay import Pay, pay_of
from harness.results.comparison import Comparison
from harness.results.pool import Pool


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
    rows: tuple[Row, ...]
    """One for each measure that decides."""
    sure: str
    """What decided, how sure it is, and whether the robot learns faster; empty where nothing decided."""
    pay: str = ""
    """How much more an episode is paid, without the end of the sentence."""
    is_ruler: bool = False
    """Whether nearly all of that is the ruler."""
    why: str = ""
    """Why there are no parts."""
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
    found, ruling = comparison.headline, comparison.ruling or Ruling()
    changes = comparison.decisive_changes
    card = _card(name, found, comparison.lead, changes, ruling)._replace(beside=tuple(beside_answer(comparison)))
    pay, faster = pay_of(comparison), _learns(comparison.speed_ruling)
    if faster:
        card = card._replace(sure=f"{card.sure} {faster}".lstrip())
    return card if pay is None else _with_pay(card, pay, found.answer)


def _learns(ruling: Ruling | None) -> str:
    """How fast the robot learns, where that is known."""
    if ruling is None or not ruling.is_decided:
        return ""
    return f"It learns {'faster' if ruling.sign > 0 else 'more slowly'}."


def pool_card(pool: Pool) -> Card:
    """The card of a reward over all places."""
    return _card(pool.names.proposed, pool.headline, pool.lead, pool.measures, pool.ruling)


def pool_cards(comparisons: Sequence[Comparison]) -> list[Card]:
    """The cards of the answers over all places, each once; none where there is one place."""
    pools = {id(it.pool): it.pool for it in comparisons if it.pool is not None}.values()
    return [pool_card(pool) for pool in pools]


def _card(name: str, found: Headline, lead: str, changes: Sequence[Compared], ruling: Ruling) -> Card:
    rows = tuple(sorted((_row(it, at, ruling, found) for at, it in enumerate(changes)), key=lambda row: not row.note))
    return Card(name, word_of(found.answer), badge_of(found.answer), lead, rows, _sure(found, changes, ruling))


def _row(change: Compared, at: int, ruling: Ruling, found: Headline) -> Row:
    baseline, proposed = short_values(change)
    note = "decides" if found.decided_by == change.name else ""
    figure = ""
    if change.baseline is not None and change.proposed is not None:
        direction = "" if not ruling.passes(at) else "better" if ruling.signs[at] > 0 else "worse"
        difference = change.proposed - change.baseline
        figure = draw_interval(difference, change.low, change.high, change.measure.better, direction)
    return Row(name_of(change), note, figure, f"{baseline} -> {proposed}")


def _sure(found: Headline, changes: Sequence[Compared], ruling: Ruling) -> str:
    if found.answer is Answer.CANNOT_TELL:
        return " ".join(text for text in (at_most_text(changes), _clear_of_zero(changes, ruling)) if text)
    decider = next((it for it in changes if it.name == found.decided_by), None)
    if decider is None:
        return ""
    told = f"Decided by {name_of(decider)}, from {changes[0].seeds} trainings of each reward."
    return f"{told} {_luck(ruling.corrected or 0.0)}"


def _clear_of_zero(changes: Sequence[Compared], ruling: Ruling) -> str:
    """Why a bar that does not reach the line is no answer by itself; empty where every bar reaches it."""
    clear = [it for it in changes if it.low is not None and it.high is not None and (it.low > 0.0 or it.high < 0.0)]
    if not clear or ruling.corrected is None:
        return ""
    names, p = " and ".join(map(name_of, clear)), 100.0 * ruling.corrected
    several = len(changes) > 1 or ruling.asked > 1
    test = "with all bars of this page" if several else "by the exact test"
    return f"The bar of {names} misses the line, but {test} luck shows one like it in {p:.0f} of 100 experiments."


def _luck(p: float) -> str:
    """The p-value of an answer in words."""
    many = math.ceil(1000.0 * p - 1e-9)
    count = "fewer than 1" if many < 1 or p < 0.001 else f"{many}"
    return f"Luck alone would show such a difference in {count} of 1,000 experiments."


NOTES = {"ruler": "same movements, other counting", "behaviour": "other movements, same counting"}
"""What the parts of the pay are."""
AGAINST = {(Answer.HURTS, True): ", for worse behaviour", (Answer.HELPS, False): ", for better behaviour"}
"""What is added where the pay goes the other way than the behaviour."""


def _with_pay(card: Card, pay: Pay, answer: Answer) -> Card:
    farthest = max((abs(part.size) for part in pay.parts), default=0.0)
    parts = tuple(
        Row(it.name, NOTES[it.name], draw_part(it.size, farthest, it.name), it.text, it.name) for it in pay.parts
    )
    told = pay.told if pay.grows is None else pay.told + AGAINST.get((answer, pay.grows), "")
    return card._replace(pay=told, is_ruler=pay.is_ruler, why=pay.why, parts=parts)


def groups_of(cards: Sequence[Card], comparisons: Sequence[Comparison]) -> list[dict[str, Any]]:
    """The comparisons of a page by their answer, with a sentence for all that have none in common.

    Args:
        cards: The card of each comparison.
        comparisons: The comparisons.
    """
    groups: dict[str, list[int]] = {}
    for number, card in enumerate(cards):
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
    if not needed:
        return "Nothing decides these comparisons."
    low, high = min(it[0] for it in needed), max(it[1] for it in needed)
    some = "" if len(needed) == len(found) else f" For {len(found) - len(needed)} of them no number can be told."
    return f"Their trainings are not enough: it takes {low:,} to {high:,} of each reward to tell them apart.{some}"
