"""Guesses which reward paid a recorded run: a registered reward that pays every row again as it was recorded."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from harness.arrays import Float, Mask
from harness.log import Log, Rows
from harness.registry.choice import choose
from harness.registry.registry import Registry
from harness.reward import MissingField
from harness.score.scorer import Payer, can_be_paid, pay_column

HEAD = 8_192
"""The number of rows that a reward has to pay again. All rows would take long for rewards that remember."""
DIGITS = 1e-6
"""What a float of 7 digits, as C# prints them, can be off: half a unit in the last place is 5e-7 of it, and of the two
numbers in a difference both are."""
LOST_SIGNS = 0.01
"""Share of rows in which the sign of Dd may be lost: distance and best distance print alike and differ."""


class Guess(NamedTuple):
    """The guess which reward paid a run."""

    choice: str | None
    """The reward as ``harness.registry.choice.choose`` takes it; None if no reward fits."""
    reason: str = ""
    """Why no reward fits."""


def guess_reward(log: Log, registry: Registry) -> Guess:
    """The first reward that pays the run's first rows as recorded.

    Tried in this order: the one that the run's manifest declares; ``baseline``; ``arp`` with the gains that the rows
    show; every other registered reward with its defaults.
    """
    path, declared = log.facts.path, log.facts.trained_with
    if not can_be_paid(log):
        return Guess(None, f"{path} has no distances to score again")
    head = _head_of(log)
    if not head[pay_column(log)].any() and not declared:
        return Guess(None, f"{path} pays nothing in its first {len(head):,} rows, as many rewards may")
    for text in dict.fromkeys(_candidates(log, head, registry)):
        try:
            if _misfit_of(text, log, head, registry) is None:
                return Guess(text)
        except (Exception, SystemExit):  # a plugin may raise anything
            continue
    besides = f"; not even {declared}, which its manifest declares" if declared else ""
    return Guess(None, f"no registered reward pays what {path} recorded{besides}")


def misfit(log: Log, text: str, registry: Registry) -> str | None:
    """Where the reward `text` does not pay a run's first rows as recorded; None if it does.

    Raises:
        UsageError: There is no such reward.
    """
    if not can_be_paid(log):
        return f"{log.facts.path} has no distances to score again"
    problem = _misfit_of(text, log, _head_of(log), registry)
    return None if problem is None else f"{log.facts.path}, {problem}"


def _head_of(log: Log) -> Rows:
    """All columns of the first rows."""
    return next(log.pieces(log.columns, HEAD))


def _candidates(log: Log, head: Rows, registry: Registry) -> Iterator[str]:
    if log.facts.trained_with:
        yield log.facts.trained_with
    yield "baseline"
    yield from _arp_of(head, head[pay_column(log)])
    yield from registry.names("rewards")


def _arp_of(head: Rows, paid: Float) -> Iterator[str]:
    """``arp`` with the gains that the rows show, to 3 digits: k2 of what is paid, k1 of what is lost."""
    gained, lost = head["begin_distance"] - head["distance"], head["delta_distance"]
    k1, k2 = _gain(-paid, lost, lost > 0.0), _gain(paid, gained, (lost <= 0.0) & (gained > 0.0))
    if k1 is not None and k2 is not None:
        yield f"arp:k1={k1:.3g},k2={k2:.3g}"


def _gain(value: Float, metres: Float, rows: Mask) -> float | None:
    """How much is paid per metre, from rows with many metres; None without a row."""
    if not rows.any():
        return None
    large = rows & (metres >= 0.5 * metres[rows].max())
    return float(np.median(value[large] / metres[large]))


def _misfit_of(text: str, log: Log, head: Rows, registry: Registry) -> str | None:
    """The first row that the reward pays otherwise; None if there is none."""
    choice, recorded = choose(registry, "rewards", text), head[pay_column(log)]
    try:
        payer = Payer(choice.build(registry, "rewards"), log)
    except MissingField as error:
        return f"no column tells {error.field}, which {choice.label} reads"
    with np.errstate(all="ignore"):  # a reward may divide by anything where it then takes another value
        paid = payer.pay(head).total
    misses = ~(np.abs(paid - recorded) <= _tolerance(paid, recorded, head))  # not finite is a miss, too
    unsure = misses & _sign_is_lost(head)
    if unsure.sum() <= max(1.0, LOST_SIGNS * len(paid)):
        misses &= ~unsure
    if not misses.any():
        return None
    row = int(np.argmax(misses))
    return f"line {log.facts.first_line + row}: recorded {recorded[row]:.7g}, {choice.label} pays {paid[row]:.7g}"


def _tolerance(paid: Float, recorded: Float, head: Rows) -> Float:
    """How far a reward may be off, (rows,), if all columns have 7 digits and it is as steep as it shows itself."""
    begin, distance, delta = head["begin_distance"], head["distance"], head["delta_distance"]
    change = np.maximum(np.abs(begin - distance), np.abs(delta))
    far = (change > 0.1 * change.max()) & (change > 0.0)
    steepness = float(np.max(np.abs(recorded[far]) / change[far], initial=1.0))
    return DIGITS * (steepness * (begin + distance) + np.abs(paid))


def _sign_is_lost(head: Rows) -> Mask:
    """Whether Dd is within what its two distances can be off, (rows,)."""
    lost: Mask = np.abs(head["delta_distance"]) <= 2.0 * DIGITS * head["distance"]
    return lost
