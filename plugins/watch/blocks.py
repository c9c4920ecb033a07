"""What the episodes of a training came to, in blocks that do not overlap: what is shown of it while it goes on."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float

MOST = 64
"""The most blocks of a training. Where there would be more, each two become one."""
PAY, BEHAVIOUR, OWN = 0, 1, 2
"""Places of the pay and of the behaviour among the numbers of an episode, and where its terms begin."""


@dataclass(frozen=True)
class Block:
    """Consecutive episodes of a training, in the order in which they ended.

    All blocks of a training have the same number of episodes, a power of two; the last one may have fewer.

    Attributes:
        steps: Environment steps of the training, over all its envs, when the last of them had ended.
        episodes: How many.
        pay: What an episode was paid, mean.
        pay_spread: Standard deviation of what an episode was paid, divided by `episodes` - 1; NaN of one.
        behaviour: Success, as a share, or the first measure; mean of an episode. NaN where nothing measures it.
        behaviour_spread: Its standard deviation; NaN of one.
    """

    steps: int
    episodes: int
    pay: float
    pay_spread: float
    behaviour: float
    behaviour_spread: float


@dataclass(frozen=True, eq=False)
class Blocks:
    """The blocks of a training. The numbers of an episode are its pay, its behaviour, and what each term paid.

    Attributes:
        terms: Of the reward.
        steps: See `Block`, (blocks,).
        episodes: See `Block`, (blocks,).
        means: Of each number, (blocks, numbers).
        squares: Sums of squared distances from the mean, (blocks, numbers).
    """

    terms: tuple[str, ...]
    steps: NDArray[np.int64]
    episodes: NDArray[np.int64]
    means: Float
    squares: Float

    @classmethod
    def of(cls, terms: Sequence[str], steps: NDArray[np.int64], numbers: Float) -> Self:
        """The blocks of episodes in the order in which they ended.

        Args:
            terms: Of the reward.
            steps: Environment steps of the training when each had ended, (episodes,).
            numbers: Of each, (episodes, numbers).
        """
        size = 2 ** max(0, math.ceil(math.log2(max(1, len(steps)) / MOST)))
        begins = np.arange(0, len(steps), size)
        ends = np.append(begins[1:], len(steps))[: len(begins)]
        counts = ends - begins
        means = np.add.reduceat(numbers, begins) / counts[:, None]
        apart = numbers - np.repeat(means, counts, axis=0)
        return cls(tuple(terms), steps[ends - 1], counts, means, np.add.reduceat(apart**2, begins))

    @property
    def listed(self) -> tuple[Block, ...]:
        """Each one, without the terms."""
        spreads = np.sqrt(self.squares / np.where(self.episodes > 1, self.episodes - 1, np.nan)[:, None])
        numbers = (of[:, place] for place in (PAY, BEHAVIOUR) for of in (self.means, spreads))
        return tuple(map(Block, *(it.tolist() for it in (self.steps, self.episodes, *numbers))))
