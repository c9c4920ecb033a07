"""What episodes were paid: the one place where the pay of their steps is added up.

What is in memory is added as NumPy adds an array, in pairs; steps that come in pieces one after the other. The last
bits of the two may differ.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.log import Log
from harness.log.log import Array
from harness.record.trace import NUMBERS

EVENTS = tuple(name for name in NUMBERS if name.startswith("reward_"))
"""The columns of the event terms, which are the same under every reward."""
PAID = ("reward", *EVENTS)
"""The columns whose sum is what an episode was paid: the shaped reward and the event terms."""


def paid_in(trace: Log, columns: Sequence[str] = PAID) -> Float:
    """What these columns paid together in each row, (rows,)."""
    paid: Float = np.sum([trace[name] for name in columns], axis=0)
    return paid


def mean_return(trace: Log, columns: Sequence[str] = PAID) -> float | None:
    """What a finished episode was paid in these columns together, mean over the episodes; None without one."""
    return mean_over_episodes(paid_in(trace, columns), trace)


def mean_over_episodes(values: Float, trace: Log) -> float | None:
    """The sum of `values`, one per row, over a finished episode, mean over the episodes; None without one."""
    sums = episode_sums(values, trace.episodes).tolist()
    return sum(sums) / len(sums) if sums else None


def episode_sums(values: Array, episodes: Sequence[NDArray[np.int64]]) -> Float:
    """The sum of `values`, one per row, over each of some episodes, (episodes,).

    Args:
        values: (rows,).
        episodes: Row numbers of each.
    """
    if not episodes:
        return np.empty(0)
    return sums_from(np.cumsum([0, *map(len, episodes[:-1])]), values[np.concatenate(episodes)])


def sums_from(begins: NDArray[np.int64], values: Array) -> Float:
    """The same of episodes that follow one another, (episodes,); `begins` are the numbers of their first rows."""
    # Behind a zero each has the bits of the sum of that episode alone.
    steps = np.insert(np.asarray(values, np.float64), begins, 0.0)
    sums: Float = np.add.reduceat(steps, begins + np.arange(len(begins)))
    return sums


@dataclass(frozen=True, eq=False)
class OpenEpisodes:
    """Sums over episodes that have not ended, of steps that come in pieces.

    Attributes:
        keys: Which episodes, by env and then number, (episodes,).
        sums: Of each column, (columns, episodes).
    """

    keys: NDArray[np.int64]
    sums: Float

    @classmethod
    def none(cls, columns: int) -> Self:
        """Before the first step."""
        return cls(np.empty(0, np.int64), np.empty((columns, 0)))

    def after(
        self, env: Array, episode: Array, ends: Array, columns: Sequence[Array]
    ) -> tuple[Self, NDArray[np.int64], Float]:
        """What is open after more steps; which of these ended an episode; the sums over these, (columns, episodes).

        Args:
            env: Its number, of each step, (steps,).
            episode: The same of the episode in its env.
            ends: Whether the step is the last of its episode, (steps,).
            columns: What is added up, (steps,) each.
        """
        keys = np.concatenate([self.keys, env.astype(np.int64) << 32 | episode.astype(np.int64)])
        episodes, where = np.unique(keys, return_inverse=True)
        sums = np.empty((len(columns), len(episodes)))
        for place, values in enumerate(columns):
            sums[place] = np.bincount(where, np.concatenate([self.sums[place], values]), len(episodes))
        rows = np.flatnonzero(ends)
        ended = where[len(self.keys) :][rows]
        # An env has one open episode at most: its last one, if it has not ended.
        is_open = np.append(np.diff(episodes >> 32) != 0, True)[: len(episodes)]
        is_open[ended] = False
        return type(self)(episodes[is_open], sums[:, is_open]), rows, sums[:, ended]
