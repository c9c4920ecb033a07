"""What the episodes of a training came to, in blocks that do not overlap: what is shown of it while it goes on."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from harness import Float, Ints

MOST = 64
"""The most blocks of a training. Where there would be more, each two become one."""
PAY, BEHAVIOUR, OWN = 0, 1, 2
"""Places of the pay and of the behaviour among the numbers of an episode, and where its terms begin."""


@dataclass(frozen=True, eq=False)
class Blocks:
    """The blocks of a training: its episodes in the order in which they ended, equally many, a power of two, in each.

    The last one may have fewer. The numbers of an episode are its pay, its behaviour, NaN where nothing measures it,
    and what each term paid.

    Attributes:
        terms: Of the reward.
        steps: Environment steps of the training, over all its envs, when the last episode of each had ended, (blocks,).
        episodes: How many are in each, (blocks,).
        means: Of each number, (blocks, numbers).
    """

    terms: tuple[str, ...]
    steps: Ints
    episodes: Ints
    means: Float

    @classmethod
    def of(cls, terms: Sequence[str], steps: Ints, numbers: Float) -> Self:
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
        return cls(tuple(terms), steps[ends - 1], counts, np.add.reduceat(numbers, begins) / counts[:, None])

    def __len__(self) -> int:
        """How many blocks there are."""
        return len(self.steps)
