"""What each term of a reward paid an episode of one training, or of its evaluations: sums over recorded columns."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.log.log import episode_sums
from harness.reward.terms import paid_twice

PART = 0.1
"""The first and the last episodes of a training, as a share of them; at least one."""


class TermMeans(NamedTuple):
    """What one term paid an episode, means over episodes; None where no episode ended."""

    start: float | None
    """Over the first tenth of the episodes, in the order in which they ended."""
    end: float | None
    """Over the last tenth."""
    whole: float | None
    """Over all of them."""
    pays: bool
    """Whether it paid anything but 0 in any step, also of an episode that did not end."""


class ByTerm(NamedTuple):
    """What the terms of a reward paid in recorded steps."""

    terms: Mapping[str, TermMeans]
    """By term, in their order; none of a reward without terms."""
    steps: int
    """How many steps there are."""
    twice: str = ""
    """See `harness.reward.terms.paid_twice`."""

    @classmethod
    def again(cls, terms: Mapping[str, Iterable[Any]], steps: int, twice: str = "") -> "ByTerm":
        """The same after a way through JSON, which makes lists of both tuples."""
        return cls({name: TermMeans(*means) for name, means in terms.items()}, steps, twice)


def part_of(episodes: int) -> int:
    """How many of so many episodes are the first of a training, and how many the last."""
    return max(1, round(PART * episodes))


def by_term(terms: Mapping[str, Float], episodes: Sequence[NDArray[np.int64]], steps: int) -> ByTerm:
    """What terms paid.

    Args:
        terms: By name, what each paid in every row, (rows,).
        episodes: Row numbers of each finished episode, in their order.
        steps: How many of the rows are steps, and no start of an episode.
    """
    ordered = sorted(episodes, key=lambda rows: int(rows[-1]))
    part = part_of(len(ordered))

    def means(values: Float) -> TermMeans:
        sums = episode_sums(values, ordered)
        start, end, whole = (float(it.mean()) if len(it) else None for it in (sums[:part], sums[-part:], sums))
        return TermMeans(start, end, whole, bool((values != 0.0).any()))

    return ByTerm({name: means(values) for name, values in terms.items()}, steps, paid_twice(terms))
