"""Guesses which reward paid a recorded run: a registered reward that pays every row again as it was recorded."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from harness.arrays import Float, Mask
from harness.registry.choice import choose
from harness.registry.registry import Registry
from harness.score.recording import Chunk, Recording
from harness.score.rescore import RecordingScorer

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


def guess_reward(recording: Recording, registry: Registry) -> Guess:
    """The first reward that pays the run's first rows as recorded.

    Tried in this order: the one that the run's manifest declares; ``baseline``; ``arp`` with the gains that the rows
    show; every other registered reward with its defaults.
    """
    if not recording.has_distances:
        return Guess(None, f"{recording.path} has no distances to score again")
    head = next(recording.chunks(HEAD, recording.fields))
    if not head.reward.any() and not recording.declared_reward:
        return Guess(None, f"{recording.path} pays nothing in its first {len(head.reward):,} rows, as many rewards may")
    for text in dict.fromkeys(_candidates(recording, head, registry)):
        try:
            if _misfit_of(text, head, registry) is None:
                return Guess(text)
        except (Exception, SystemExit):  # a plugin may raise anything
            continue
    declared = f"; not even {recording.declared_reward}, which its manifest declares" * bool(recording.declared_reward)
    return Guess(None, f"no registered reward pays what {recording.path} recorded{declared}")


def misfit(recording: Recording, text: str, registry: Registry) -> str | None:
    """Where the reward `text` does not pay a run's first rows as recorded; None if it does.

    Raises:
        UsageError: There is no such reward.
    """
    if not recording.has_distances:
        return f"{recording.path} has no distances to score again"
    problem = _misfit_of(text, next(recording.chunks(HEAD, recording.fields)), registry)
    return None if problem is None else f"{recording.path}, {problem}"


def _candidates(recording: Recording, head: Chunk, registry: Registry) -> Iterator[str]:
    if recording.declared_reward:
        yield recording.declared_reward
    yield "baseline"
    yield from _arp_of(head)
    yield from registry.names("rewards")


def _arp_of(head: Chunk) -> Iterator[str]:
    """``arp`` with the gains that the rows show, to 3 digits: k2 of what is paid, k1 of what is lost."""
    assert head.begin_distance is not None
    assert head.distance is not None
    assert head.delta_distance is not None
    gained, lost = head.begin_distance - head.distance, head.delta_distance
    k1, k2 = _gain(-head.reward, lost, lost > 0.0), _gain(head.reward, gained, (lost <= 0.0) & (gained > 0.0))
    if k1 is not None and k2 is not None:
        yield f"arp:k1={k1:.3g},k2={k2:.3g}"


def _gain(value: Float, metres: Float, rows: Mask) -> float | None:
    """How much is paid per metre, from rows with many metres; None without a row."""
    if not rows.any():
        return None
    large = rows & (metres >= 0.5 * metres[rows].max())
    return float(np.median(value[large] / metres[large]))


def _misfit_of(text: str, head: Chunk, registry: Registry) -> str | None:
    """The first row that the reward pays otherwise; None if there is none."""
    choice = choose(registry, "rewards", text)
    scorer = RecordingScorer(choice.build(registry, "rewards"), tuple(head.more))
    if missing := [field for field in scorer.fields if field not in head.more]:
        return f"no column tells {', '.join(missing)}, which {choice.label} reads"
    with np.errstate(all="ignore"):  # a reward may divide by anything where it then takes another value
        paid = scorer.pay(head).total
    misses = ~(np.abs(paid - head.reward) <= _tolerance(paid, head))  # not finite is a miss, too
    unsure = misses & _sign_is_lost(head)
    if unsure.sum() <= max(1.0, LOST_SIGNS * len(paid)):
        misses &= ~unsure
    if not misses.any():
        return None
    row = int(np.argmax(misses))
    return f"line {head.line + row}: recorded {head.reward[row]:.7g}, {choice.label} pays {paid[row]:.7g}"


def _tolerance(paid: Float, head: Chunk) -> Float:
    """How far a reward may be off, (rows,), if all columns have 7 digits and it is as steep as it shows itself."""
    assert head.begin_distance is not None
    assert head.distance is not None
    assert head.delta_distance is not None
    metres = head.begin_distance + head.distance
    change = np.maximum(np.abs(head.begin_distance - head.distance), np.abs(head.delta_distance))
    far = (change > 0.1 * change.max()) & (change > 0.0)
    steepness = float(np.max(np.abs(head.reward[far]) / change[far], initial=1.0))
    return DIGITS * (steepness * metres + np.abs(paid))


def _sign_is_lost(head: Chunk) -> Mask:
    """Whether Dd is within what its two distances can be off, (rows,)."""
    assert head.distance is not None
    assert head.delta_distance is not None
    lost: Mask = np.abs(head.delta_distance) <= 2.0 * DIGITS * head.distance
    return lost
