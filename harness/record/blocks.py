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
from typing_extensions import TypedDict

from harness.arrays import Float
from harness.errors import SchemaError
from harness.files.bounded import read_json, reading
from harness.files.whole_file import whole_files
from harness.record.file_forms import EXACT, Count, Name, Number, Whole, read_form

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
        free = np.where(self.episodes > 1, self.episodes - 1, 1)[:, None]
        spreads = np.where(self.episodes[:, None] > 1, np.sqrt(self.squares / free), math.nan)
        return tuple(
            Block(steps, episodes, mean[PAY], spread[PAY], mean[BEHAVIOUR], spread[BEHAVIOUR])
            for steps, episodes, mean, spread in zip(
                self.steps.tolist(), self.episodes.tolist(), self.means.tolist(), spreads.tolist(), strict=True
            )
        )

    def write(self, folder: Path) -> None:
        """Write them down for who looks from another process; they need not survive a machine that stops."""
        rows = np.column_stack([self.means, self.squares])
        told = {
            "terms": self.terms,
            "steps": self.steps.tolist(),
            "episodes": self.episodes.tolist(),
            "numbers": [[None if math.isnan(number) else number for number in row] for row in rows.tolist()],
        }
        with whole_files(folder, [BLOCKS], is_lasting=False) as (partial,):
            partial.write_text(json.dumps(told))


def read_blocks(folder: Path) -> Blocks | None:
    """What `Blocks.write` wrote last; None before that, and where it cannot be read: nothing depends on it."""
    try:
        with reading(folder / BLOCKS, "account of a training"):
            told = read_form(BlocksForm, read_json(folder / BLOCKS))
            numbers = 2 * (OWN + len(told["terms"]))
            rows = np.array(told["numbers"], np.float64).reshape(-1, numbers)
            steps, episodes = np.array(told["steps"], np.int64), np.array(told["episodes"], np.int64)
            means, squares = np.hsplit(rows, 2)
            is_whole = len(steps) == len(episodes) == len(rows)
            return Blocks(tuple(told["terms"]), steps, episodes, means, squares) if is_whole else None
    except SchemaError:
        return None


@with_config(EXACT)
class BlocksForm(TypedDict):
    """See `Blocks`."""

    terms: Annotated[list[Name], Field(max_length=1_000)]
    steps: Annotated[list[Whole], Field(max_length=MOST)]
    episodes: Annotated[list[Count], Field(max_length=MOST)]
    numbers: Annotated[list[list[Number | None]], Field(max_length=MOST)]
