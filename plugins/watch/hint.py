"""Whether pay rises while behaviour falls, within one training: a hint for who watches it, and no verdict."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf, log, sqrt
from typing import Self

import numpy as np
from scipy.special import stdtr

from harness.arrays import Float
from harness.eta import Better

from .blocks import MOST, Block

ERROR = 0.05
"""At most this share of trainings in which pay does not rise or behaviour does not fall ever has a hint.

In simulations none of 2,200 had one, 200 of each of 11 kinds. That holds where chance hits each episode anew, or half
of a deviation stays to the next one. Luck that lasts is a fall while it lasts: where nine tenths of a deviation stay,
12 % of trainings have a hint, of success 24 %; where 98 % stay, 46 % (`tests.plugins.watch.cases.nulls`).
"""
WIDTHS = (4, 8, 16)
"""Blocks of the windows that are compared."""
LEAST_SHARE = 0.1
"""A smaller fall of success does not matter."""
LEAST_OF_RANGE = 0.2
"""A fall by less than this share of the range of all blocks does not matter."""


@dataclass(frozen=True)
class Hint:
    """Between two windows of a training pay rose and behaviour fell.

    Attributes:
        since: Environment steps at the end of the earlier window.
        pay: Mean of an episode, earlier and last.
        behaviour: The same.
        measure: Name of the behaviour.
        is_share: Whether each episode succeeds or fails.
        better: Which values of the measure are better: where it is less, it rose.
    """

    since: int
    pay: tuple[float, float]
    behaviour: tuple[float, float]
    measure: str
    is_share: bool
    better: Better

    @property
    def text(self) -> str:
        """One line."""
        before, now = (f"{100 * it:.0f} %" if self.is_share else f"{it:.3g}" for it in self.behaviour)
        paid, pays = (f"{it:.3g}" for it in self.pay)
        moved = "rose" if self.better == "lower" else "fell"
        return (
            f"Pay rose from {paid} to {pays} since step {self.since:,} while {self.measure} {moved} from {before} to "
            f"{now}. It is a hint, not a verdict."
        )


def is_flag(blocks: Sequence[Block]) -> bool:
    """Whether each episode's behaviour is 0 or 1."""
    return _Series.of(blocks, "behaviour").is_share


def hint_of(blocks: Sequence[Block], better: Better, measure: str = "success") -> Hint | None:
    """What a training's blocks hint at, or None.

    The last blocks are compared with all earlier ones, in windows of `WIDTHS`. A hint needs two t tests at once: pay
    has risen, so that something was learned, and behaviour has fallen, if only below what an untrained robot does.
    All looks at a training of any length share `ERROR`: each size of block has its part, of that each width, and of
    that each pair of windows that blocks of this size can ever make (Bonferroni).

    Args:
        blocks: Of one training; the last one is left out while it has fewer episodes than the others.
        better: Which values of the behaviour are better; where nobody says it, nothing is hinted at.
        measure: Name of the behaviour.
    """
    whole = [it for it in blocks if it.episodes == blocks[0].episodes]
    pay = _Series.of(whole, "pay")
    behaviour = _Series.of(whole, "behaviour")
    worse = behaviour if better == "lower" else behaviour.negative
    least = max(LEAST_OF_RANGE * worse.range, LEAST_SHARE * behaviour.is_share)
    found = [
        (min(pay.surprise(pair), worse.surprise(pair)) - pair.needed(blocks[0].episodes), pair)
        for pair in _pairs(len(whole))
        if worse.rise(pair) >= least and pay.rise(pair) > 0.0  # false of NaN
    ]
    excess, pair = max(found, default=(-1.0, None))
    if pair is None or excess < 0.0 or not better:
        return None
    return Hint(
        since=whole[pair.earlier.stop - 1].steps,
        pay=pay.means_of(pair),
        behaviour=behaviour.means_of(pair),
        measure=measure,
        is_share=behaviour.is_share,
        better=better,
    )


@dataclass(frozen=True, order=True)
class _Pair:
    """Two windows of equally many blocks that do not overlap: where each begins, and its width."""

    width: int
    begin: int
    last: int

    @property
    def earlier(self) -> slice:
        return slice(self.begin, self.begin + self.width)

    @property
    def later(self) -> slice:
        return slice(self.last, self.last + self.width)

    def needed(self, episodes: int) -> float:
        """What a surprise has to reach, in nats, where a block has so many episodes."""
        size = episodes.bit_length()  # 1, 2, 3 ...: the parts 1 / 2, 1 / 6, 1 / 12 ... make 1 together
        lasts = 2 * MOST // self.width - 3  # where a window may begin that has one before it, in steps of half a width
        pairs = lasts * (lasts + 1) / 2
        return log(size * (size + 1) * len(WIDTHS) * pairs / ERROR)


def _pairs(count: int) -> Iterator[_Pair]:
    """The newest window of each width, which moves by half of it, with each one before it."""
    for width in WIDTHS:
        half = width // 2
        last = count // half * half - width
        for begin in range(0, last - width + 1, half):
            yield _Pair(width, begin, last)


@dataclass(frozen=True, eq=False)
class _Series:
    """A number of a training's episodes, by block.

    Attributes:
        means: (blocks,).
        variances: Of the mean of a block, from what its episodes differ by, (blocks,); 0 of one episode.
        is_share: Whether each episode's number is 0 or 1.
    """

    means: Float
    variances: Float
    is_share: bool

    @classmethod
    def of(cls, blocks: Sequence[Block], name: str) -> Self:
        """The series of a number by its name in `Block`."""
        columns = (name, f"{name}_spread", "episodes")
        means, spreads, episodes = (np.array([getattr(it, column) for it in blocks], float) for column in columns)
        squares = np.nan_to_num(spreads) ** 2
        of_shares = means * (1.0 - means) * episodes  # the sum of squares about the mean, if all are 0 or 1
        is_share = bool(np.allclose(squares * (episodes - 1.0), of_shares, atol=1e-6))
        return cls(means, squares / episodes, is_share)

    @property
    def negative(self) -> Self:
        """The same with the other sign."""
        return replace(self, means=-self.means)

    @cached_property
    def range(self) -> float:
        """The greatest mean less the least."""
        return float(np.ptp(self.means)) if len(self.means) else 0.0

    def means_of(self, pair: _Pair) -> tuple[float, float]:
        """The mean of the earlier window and of the later one."""
        sums, width = self.sums, pair.width
        first, last = sums[pair.begin + width] - sums[pair.begin], sums[pair.last + width] - sums[pair.last]
        return first / width, last / width

    @cached_property
    def sums(self) -> list[float]:
        """Sums of the means before each block, and of all."""
        return [0.0, *np.cumsum(self.means).tolist()]

    def rise(self, pair: _Pair) -> float:
        """The later window less the earlier one."""
        before, now = self.means_of(pair)
        return now - before

    def surprise(self, pair: _Pair) -> float:
        """The surprise of a rise, in nats: -log p of a t test.

        The error of a window's mean is the largest of three: from block to block in both windows, from block to block
        in the whole training, which no calm window hides, and within blocks. What neighbours differ by is taken, so
        that a drift is no error; how alike they are makes it larger.
        """
        windows = self.means[pair.earlier], self.means[pair.later]
        near = float(np.mean([np.mean(np.diff(it) ** 2) for it in windows]))
        within = float(np.mean(self.variances[pair.earlier]) + np.mean(self.variances[pair.later]))
        alone = (1.0 - self.alike) / (1.0 + self.alike)  # so much of a block says something new
        error = max(near, self.neighbours, within) / alone / pair.width
        rise = self.rise(pair)
        if error == 0.0:
            return inf if rise > 0.0 else 0.0
        chance = float(stdtr(2 * pair.width - 2, -rise / sqrt(error)))
        return -log(chance) if chance > 0.0 else inf

    @cached_property
    def neighbours(self) -> float:
        """Mean squared difference of neighbours in the whole training."""
        return float(np.mean(np.diff(self.means) ** 2))

    @cached_property
    def alike(self) -> float:
        """How much of a deviation stays to the next block, 0 to 0.9: blocks two apart differ by more than neighbours.

        Of medians, so that a jump does not count. Where most neighbours are equal, as successes are, the median is 0:
        then of means without the largest jump.
        """
        squares = [np.sort((self.means[gap:] - self.means[:-gap]) ** 2) for gap in (1, 2)]
        near, far = (float(np.median(it)) for it in squares)
        if near == 0.0:
            near, far = (float(np.mean(it[:-gap])) if len(it) > gap else 0.0 for gap, it in enumerate(squares, 1))
        return min(max(far / near - 1.0, 0.0), 0.9) if near > 0.0 else 0.0
