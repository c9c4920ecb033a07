"""Tells the files of one training's environments from those of several trainings, by when their episodes ended."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from harness.arrays import Float
from harness.log import Log

NEAR = 10
"""Episodes of two files that end within so many steps are compared; clocks of processes drift further than that."""
LEAST = 6
"""So many of them tell; of fewer, separate processes may have ended in one order by chance."""
FITTING = 0.9
"""The share of episodes which end in the same step that have to end at the same time; a computer may be busy once."""
CLOCK = 1e-3
"""What a clock may be wrong by, [s]."""


class _Ends(NamedTuple):
    """The ends of all episodes of several files, in the order of their steps, (rows,)."""

    steps: Float
    at: Float
    """Unix time, [s]."""
    file: Float
    last_begun: float
    """When the last file was begun, in Unix time, [s]."""
    per_step: float
    """Seconds for a step of an environment, learning included."""


def in_lockstep(logs: Iterable[Log]) -> bool | None:
    """Whether logs are of environments that one training steps together, so that it is one training.

    Such environments have taken equal numbers of steps at any time: whatever ends in an earlier step ends earlier.
    Processes of their own drift apart, and trainings one after the other are apart from the start.

    Args:
        logs: Two or more logs of episodes.

    Returns:
        True if all go together, False if some do not. None if nobody can tell: there are too few episodes, or no times.
    """
    ends = _ends_of([*logs])
    if ends is None:
        return None
    if _are_one_after_the_other(ends):
        return False
    late = _latest_disorder(ends)
    if late > CLOCK:
        return False if late > NEAR * ends.per_step else None
    gaps, waits = np.diff(ends.steps), np.diff(ends.at)
    near = (np.diff(ends.file) != 0) & (gaps <= NEAR)
    equal = waits[near & (gaps == 0)]
    is_apart = len(equal) > 0 and (equal <= NEAR * ends.per_step).mean() < FITTING
    has_no_clock = not waits[near].any()  # its ticks are too long to tell, or somebody made the times up
    return None if near.sum() < LEAST or is_apart or has_no_clock else True


def _ends_of(logs: Sequence[Log]) -> _Ends | None:
    """None where a file does not tell when its episodes ended."""
    if any(log.facts.started is None or "seconds" not in log or "time" not in log for log in logs):
        return None
    began = np.array([log.facts.started for log in logs], np.float64)
    steps = np.concatenate([log["time"] for log in logs]).astype(np.float64)
    at = np.concatenate([start + log["seconds"] for start, log in zip(began, logs, strict=True)]).astype(np.float64)
    file = np.concatenate([np.full(len(log), number, np.float64) for number, log in enumerate(logs)])
    if not np.isfinite(at).all():
        return None
    order = np.lexsort((at, steps))
    per_step = float((at.max() - began.min()) / steps.max())
    return _Ends(steps[order], at[order], file[order], float(began.max()), per_step)


def _are_one_after_the_other(ends: _Ends) -> bool:
    """Whether a file was full before another one was begun."""
    return any(ends.at[ends.file == number].max() < ends.last_begun for number in np.unique(ends.file))


def _latest_disorder(ends: _Ends) -> float:
    """By how many seconds, at most, an end came before another one's of fewer steps; 0 or less where none did."""
    latest = np.maximum.accumulate(ends.at)
    earlier = np.searchsorted(ends.steps, ends.steps, side="left")
    compared = earlier > 0
    if not compared.any():
        return 0.0
    return float((latest[earlier[compared] - 1] - ends.at[compared]).max())
