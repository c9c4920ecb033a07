"""What the episodes of a training came to, in blocks that do not overlap: what is shown of it while it goes on.

A cell of an arm keeps ``blocks.json`` in its partial folder while it trains; who looks from another process reads it.
Traces and recordings give the same blocks when they are read.
"""

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, with_config

from harness.arrays import Float
from harness.errors import SchemaError
from harness.files.bounded import read_json, reading, whole_files
from harness.record.file_forms import EXACT, Name, Number, Whole, read_form, told_as

BLOCKS = "blocks.json"
"""In a partial folder: what the training's episodes came to so far."""
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


Counts = Annotated[NDArray[np.int64], told_as(Annotated[list[Whole], Field(max_length=MOST)], np.int64)]
Numbers = Annotated[Float, told_as(Annotated[list[list[Number | None]], Field(max_length=MOST)], np.float64)]


@with_config(EXACT)
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

    terms: Annotated[tuple[Name, ...], Field(max_length=1_000)]
    steps: Counts
    episodes: Counts
    means: Numbers
    squares: Numbers

    @classmethod
    def none(cls, terms: Sequence[str] = ()) -> Self:
        """The blocks of a training in which no episode has ended."""
        nothing, numbers = np.empty(0, np.int64), np.empty((0, OWN + len(terms)))
        return cls(tuple(terms), nothing, nothing, numbers, numbers)

    def followed_by(self, steps: NDArray[np.int64], numbers: Float) -> Self:
        """The same, and more episodes in the order in which they ended.

        Args:
            steps: Environment steps of the training when each had ended, (episodes,).
            numbers: Of each, (episodes, numbers).
        """
        episodes = np.concatenate([self.episodes, np.ones(len(steps), np.int64)])
        means, squares = np.concatenate([self.means, numbers]), np.concatenate([self.squares, np.zeros_like(numbers)])
        if not len(episodes):
            return self
        total = int(episodes.sum())
        size = 2 ** max(0, math.ceil(math.log2(total / MOST)))
        # Every block begins where a smaller one began, since all are powers of two.
        begins = np.flatnonzero(np.diff((np.cumsum(episodes) - episodes) // size, prepend=-1))
        counts = np.add.reduceat(episodes, begins)
        of_all = np.add.reduceat(means * episodes[:, None], begins) / counts[:, None]
        apart = means - np.repeat(of_all, np.diff([*begins, len(episodes)]), axis=0)
        return replace(
            self,
            steps=np.concatenate([self.steps, steps])[np.append(begins[1:], len(episodes)) - 1],
            episodes=counts,
            means=of_all,
            squares=np.add.reduceat(squares + episodes[:, None] * apart**2, begins),
        )

    def until(self, steps: int) -> Self:
        """Those that had ended after `steps` environment steps."""
        there = self.steps <= steps
        return replace(self, **{name: getattr(self, name)[there] for name in ("steps", "episodes", "means", "squares")})

    @property
    def listed(self) -> tuple[Block, ...]:
        """Each one, without the terms."""
        spreads = np.sqrt(self.squares / np.where(self.episodes > 1, self.episodes - 1, np.nan)[:, None])
        numbers = (of[:, place] for place in (PAY, BEHAVIOUR) for of in (self.means, spreads))
        return tuple(map(Block, *(it.tolist() for it in (self.steps, self.episodes, *numbers))))

    def write(self, folder: Path) -> None:
        """Write them down for who looks from another process; they need not survive a machine that stops."""
        arrays = {name: it for name, it in vars(self).items() if name != "terms"}
        told = {name: np.where(np.isnan(it), np.array(None), it).tolist() for name, it in arrays.items()}
        with whole_files(folder, [BLOCKS], is_lasting=False) as (partial,):
            partial.write_text(json.dumps({"terms": self.terms, **told}))


def read_blocks(folder: Path) -> Blocks | None:
    """What `Blocks.write` wrote last; None before that, and where it cannot be read: nothing depends on it."""
    try:
        with reading(folder / BLOCKS, "account of a training"):
            blocks = read_form(Blocks, read_json(folder / BLOCKS))
            shape = len(blocks.steps), OWN + len(blocks.terms)
            is_whole = blocks.means.shape == blocks.squares.shape == shape and blocks.episodes.shape == shape[:1]
            return blocks if is_whole and blocks.episodes.all() else None
    except SchemaError:
        return None
