"""What the episodes of a trace were paid."""

from collections.abc import Sequence

import numpy as np

from harness.arrays import Float
from harness.log import Log
from harness.log.log import Columns, episode_sums
from harness.record.trace import NUMBERS

EVENTS = tuple(name for name in NUMBERS if name.startswith("reward_"))
"""The columns of the event terms, which are the same under every reward."""
PAID = ("reward", *EVENTS)
"""The columns whose sum is what an episode was paid: the shaped reward and the event terms."""


def paid_in(trace: Log | Columns, columns: Sequence[str] = PAID) -> Float:
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
