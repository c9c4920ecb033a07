"""What is right, computed in the plainest way there is, and not as the program does."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.float64]


class Told(NamedTuple):
    """An episode as a data set tells of it.

    Attributes:
        pay: The sum of its rewards.
        success: Whether it succeeded; None where nothing says it.
        task: Pairs are of one task.
        body: What tells it from others; equal ones count once.
    """

    pay: float
    success: bool | None
    task: int
    body: bytes


def auc_within_tasks(episodes):
    """The share of pairs of a success and a failure of one task in which the success is paid more; ties count half."""
    distinct = {(episode.body, episode.task): episode for episode in episodes}.values()
    won = [
        1.0 if one.pay > other.pay else 0.5 if one.pay == other.pay else 0.0
        for one in distinct
        for other in distinct
        if one.success is True and other.success is False and one.task == other.task
    ]
    return sum(won) / len(won) if won else None


def indices(rewards):
    """I_N and I_P of runs: running sums, cut to the shortest run, their mean, its negative and its positive values."""
    steps = min(map(len, rewards))
    total = np.zeros(steps)
    for run in rewards:
        so_far = 0.0
        for step in range(steps):
            so_far += run[step]
            total[step] += so_far
    mean = total / len(rewards)
    return float(sum(value for value in mean if value < 0)), float(sum(value for value in mean if value > 0))


def etas(baseline, proposed):
    """eta_N and eta_P; None where the baseline's index is 0."""
    ours, theirs = indices(proposed), indices(baseline)
    eta_n, eta_p = (our / their if their else None for our, their in zip(ours, theirs, strict=True))
    return eta_n, eta_p


def first_negative_and_crossover(rewards):
    """The first step of the mean curve below 0, and the first one after it that is not; counted from 0."""
    steps = min(map(len, rewards))
    mean = sum(np.cumsum(np.asarray(run[:steps], np.float64)) for run in rewards) / len(rewards)
    first = next((step for step in range(steps) if mean[step] < 0), None)
    if first is None:
        return None, None
    return first, next((step for step in range(first, steps) if mean[step] >= 0), None)


class Row(NamedTuple):
    """A step of the experimenters' arm, or the start of an episode.

    Attributes:
        begin: Distance at the start, or when the target was drawn anew, [m].
        distance: After the step, [m].
        is_start: Whether an episode starts with it.
    """

    begin: float
    distance: float
    is_start: bool


def accelerated(rows, k1, k2):
    """ARP of each row: Dd = d - Pb; Dd > 0: -K1 Dd; else K2 (Bd - d), then Pb <- d. An episode's start is paid 0."""
    paid, best, begin = [], 0.0, -1.0
    for row in rows:
        if row.is_start or row.begin != begin:
            best = begin = row.begin
        if row.is_start:
            paid.append(0.0)
            continue
        apart = row.distance - best
        paid.append(-k1 * apart if apart > 0 else k2 * (row.begin - row.distance))
        best = min(best, row.distance)
    return paid
