"""What the episodes of a trace were paid."""

import numpy as np

from harness.arrays import Float
from harness.log import Log
from harness.record.trace import NUMBERS

EVENTS = tuple(name for name in NUMBERS if name.startswith("reward_"))
"""The columns of the event terms, which are the same under every reward."""
PAID = ("reward", *EVENTS)
"""The columns whose sum is what an episode was paid: the shaped reward and the event terms."""


def mean_return(trace: Log, columns: tuple[str, ...] = PAID) -> float | None:
    """What a finished episode was paid in these columns together, mean over the episodes; None without one."""
    return mean_over_episodes(np.sum([trace[name] for name in columns], axis=0), trace)


def mean_over_episodes(values: Float, trace: Log) -> float | None:
    """The sum of `values`, one per row, over a finished episode, mean over the episodes; None without one."""
    sums = episode_sums(values, trace)
    return sum(sums) / len(sums) if sums else None


def episode_sums(values: Float, trace: Log) -> list[float]:
    """The sum of `values`, one per row, over each finished episode."""
    return [float(values[rows].sum()) for rows in trace.episodes]


def events_of(trace: Log) -> Float:
    """What all events together paid in each row, (rows,)."""
    paid: Float = np.sum([trace[name] for name in EVENTS], axis=0)
    return paid
