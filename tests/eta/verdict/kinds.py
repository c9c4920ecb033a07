"""Trainings of two rewards whose means are equal: how they end, in 25 kinds, and what a test says of them."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from harness.eta import Question

HORIZON, FASTEST = 5.0, 2.0
"""Seconds that a training which fails, or succeeds, takes to the target."""
ENDS = np.array([[0.0, 1.0], [-HORIZON, 0.0], [0.0, 1.0]])
"""Of success, minus the time, and success while training."""
LOST = np.nan
Draw = Callable[[Generator, tuple[int, ...]], np.ndarray]


def spread(mean, deviation):
    """Trainings with a bell curve, cut off at both ends."""
    return lambda rng, shape: np.clip(mean + deviation * rng.normal(size=shape), 0.0, 1.0)


def failing(share, success, least=0.0):
    """A share of the trainings ends at `least`, all others near `success`."""

    def draw(rng, shape):
        near = np.clip(success + 0.02 * rng.normal(size=shape), 0.0, 1.0) if success < 1.0 else 1.0
        return np.where(rng.random(shape) < share, least, near)

    return draw


def beta(one, other):
    """Trainings after a beta distribution, of mean one / (one + other)."""
    return lambda rng, shape: rng.beta(one, other, shape)


def crashing(draw, is_lost):
    """The same, but for those that leave no value."""

    def lossy(rng, shape):
        values = draw(rng, shape)
        return np.where(is_lost(rng, values), LOST, values)

    return lossy


def by_luck(share):
    """Any training may crash."""
    return lambda rng, values: rng.random(values.shape) < share


def below(least):
    """Those that end worse crash."""
    return lambda rng, values: values < least


class Kind(NamedTuple):
    """How the baseline's and the proposed reward's trainings end, and for each seed of one how many the other has."""

    baseline: Draw
    proposed: Draw
    counts: tuple[float, float] = (1.0, 1.0)


KINDS = {
    "bell curve": Kind(spread(0.5, 0.18), spread(0.5, 0.18)),
    "bell curve near 1": Kind(spread(0.9, 0.18), spread(0.9, 0.18)),
    "bell curves, .10 and .24 wide": Kind(spread(0.5, 0.10), spread(0.5, 0.24)),
    "bell curves, .24 and .10 wide": Kind(spread(0.5, 0.24), spread(0.5, 0.10)),
    "learns or not, 1 in 2": Kind(failing(0.5, 0.95), failing(0.5, 0.95)),
    "learns or not, 4 in 5": Kind(failing(0.2, 0.95), failing(0.2, 0.95)),
    "1 in 10 fails": Kind(failing(0.1, 0.93), failing(0.1, 0.93)),
    "1 in 20 fails": Kind(failing(0.05, 0.93), failing(0.05, 0.93)),
    "steady, 1 in 10 fails": Kind(spread(0.837, 0.02), failing(0.1, 0.93)),
    "steady, 1 in 5 fails": Kind(spread(0.76, 0.02), failing(0.2, 0.95)),
    "steady, 1 in 20 fails": Kind(spread(0.9025, 0.02), failing(0.05, 0.95)),
    "steady, perfect but 1 in 10": Kind(spread(0.9, 0.02), failing(0.1, 1.0)),
    "steady, perfect but 1 in 20": Kind(spread(0.95, 0.01), failing(0.05, 1.0)),
    "perfect but 1 in 10, steady": Kind(failing(0.1, 1.0), spread(0.9, 0.02)),
    "steady, all or nothing .8": Kind(spread(0.8, 0.02), failing(0.2, 1.0)),
    "steady, all or nothing .5": Kind(spread(0.5, 0.02), failing(0.5, 1.0)),
    "steady, all or nothing .2": Kind(spread(0.2, 0.02), failing(0.8, 1.0)),
    "beta (.5, .5)": Kind(beta(0.5, 0.5), beta(0.5, 0.5)),
    "beta (8, 2) and (1, .25)": Kind(beta(8.0, 2.0), beta(1.0, 0.25)),
    "steady, 1 in 10 half as good": Kind(spread(0.8835, 0.02), failing(0.1, 0.93, 0.465)),
    "4 times as many steady": Kind(spread(0.837, 0.02), failing(0.1, 0.93), (4.0, 1.0)),
    "4 times as many that fail": Kind(spread(0.837, 0.02), failing(0.1, 0.93), (1.0, 4.0)),
    "half of one crashes": Kind(spread(0.475, 0.02), crashing(failing(0.5, 0.95), below(0.5))),
    "bad ones of one crash": Kind(spread(0.5, 0.18), crashing(spread(0.5, 0.18), below(0.35))),
    "3 in 10 of one crash": Kind(spread(0.5, 0.18), crashing(spread(0.5, 0.18), by_luck(0.3))),
}


def measured(success, rng, measures):
    """Success, minus the time, and success while training, which follow it; (..., measures)."""
    learning = np.clip(0.2 + 0.5 * success + 0.02 * rng.normal(size=success.shape), 0.0, 1.0)
    return np.stack([success, -(HORIZON - (HORIZON - FASTEST) * success), learning], axis=-1)[..., :measures]


def question_of(kind, rng, seeds, places=1, measures=1, effect=0.0):
    """A question about so many trainings of each reward in each place."""
    counts = [max(2, round(seeds * of)) for of in kind.counts]
    values, begun = np.full((2, max(counts), places, measures), np.nan), np.zeros((2, max(counts), places), bool)
    for side, (draw, count) in enumerate(zip(kind[:2], counts, strict=True)):
        success = np.clip(draw(rng, (count, places)) + effect * side, 0.0, 1.0)
        values[side, :count], begun[side, :count] = measured(success, rng, measures), True
    return Question.of(values, np.tile(ENDS[:measures], (places, 1, 1)), begun)
