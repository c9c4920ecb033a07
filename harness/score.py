"""Pays a recorded run again under any reward, exactly as the learner would have been paid."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from harness.carry import put, take
from harness.reward import Carry, Reward, Sample
from harness.trace import Trace

Float = NDArray[np.float64]


BLOCK = 65_536
"""Rows are scored so many at a time: the columns of a block stay in the processor's cache."""


class Rows(Protocol):
    """Consecutive rows of one run, arrays of shape (rows,)."""

    @property
    def start(self) -> NDArray[np.bool_]:
        """Whether the row is an episode's start, which is paid nothing."""

    @property
    def begin_distance(self) -> Float:
        """Bd, [m]."""

    @property
    def previous_best(self) -> Float:
        """Pb before the step, [m]."""

    @property
    def distance(self) -> Float:
        """d(t), [m]."""


class Scorer:
    """Scores one run, a piece at a time; remembers what the reward does, and the last distance."""

    def __init__(self, reward: Reward) -> None:
        self._reward = reward
        self._carry: Carry = None
        self._last = (np.nan, np.nan, 0.0)  # begin distance, distance and step of the row before

    def score(self, rows: Rows) -> Float:
        """Shaped reward of the next rows, (rows,); 0 in the start rows."""
        count = len(rows.distance)
        values = np.empty(count)
        for first in range(0, count, BLOCK):
            values[first : first + BLOCK] = self._score_block(_Block(rows, slice(first, first + BLOCK)))
        return values

    def _score_block(self, rows: Rows) -> Float:
        sample = self._sample(rows)
        empty = self._reward.initial_carry(sample.begin_distance[:1])
        if isinstance(empty, tuple) and not empty:  # remembers nothing: all rows at once
            value = np.asarray(self._reward((), sample)[1], np.float64)
        else:
            value = self._score_in_order(rows.start, sample)
        return np.where(rows.start, 0.0, value)

    def _sample(self, rows: Rows) -> Sample:
        begin, distance = rows.begin_distance, rows.distance
        last_begin, last_distance, last_step = self._last
        # The target can be drawn again inside an episode: the distance before then belongs to another target.
        same = ~rows.start & (begin == np.concatenate([[last_begin], begin[:-1]]))
        previous = np.where(same, np.concatenate([[last_distance], distance[:-1]]), begin)
        step = _steps_since_start(rows.start, last_step)
        self._last = (float(begin[-1]), float(distance[-1]), float(step[-1]))
        return Sample(begin, rows.previous_best, previous, distance, distance - rows.previous_best, step)

    def _score_in_order(self, start: NDArray[np.bool_], sample: Sample) -> Float:
        """What a reward remembers comes from the rows before: all episodes of the block side by side, step by step."""
        row, ends = np.flatnonzero(_begins(start)), np.append(np.flatnonzero(start[1:]) + 1, len(start))
        carry = self._reward.initial_carry(sample.begin_distance[row])
        if self._carry is not None and not start[0]:  # the first goes on from the block before
            carry = put(carry, np.array([0]), self._carry)
        values = np.zeros(len(start))
        row = row + start[row]  # a start row is paid nothing, and remembered as no step
        while (running := row < ends).any():
            rows = row[running]
            after, values[rows] = self._reward(take(carry, running), Sample(*(column[rows] for column in sample)))
            carry = put(carry, running, after)
            row = row + running
        self._carry = take(carry, np.array([len(ends) - 1]))
        return values


class _Block:
    """Some of the rows."""

    def __init__(self, rows: Rows, part: slice) -> None:
        self.start = rows.start[part]
        self.begin_distance = rows.begin_distance[part]
        self.previous_best = rows.previous_best[part]
        self.distance = rows.distance[part]


class _TraceRows:
    """One env's rows of a trace, in order."""

    def __init__(self, trace: Trace, rows: NDArray[np.int64] | slice) -> None:
        self.start = trace["step"][rows] == 0
        self.begin_distance = trace["begin_distance"][rows]
        self.previous_best = trace["previous_best"][rows]
        self.distance = trace["distance"][rows]


def score_trace(reward: Reward, trace: Trace) -> Float:
    """The shaped reward of every row of a trace under `reward`, (rows,), in the trace's order."""
    values = np.empty(len(trace))
    envs = np.flatnonzero(np.bincount(trace["env"]))
    for env in envs:
        rows = np.flatnonzero(trace["env"] == env) if len(envs) > 1 else slice(None)  # of one env all, without a copy
        values[rows] = Scorer(reward).score(_TraceRows(trace, rows))
    return values


def _begins(start: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The first row of each episode, or of what is left of one."""
    begins = start.copy()
    begins[0] = True
    return begins


def _steps_since_start(start: NDArray[np.bool_], before: float) -> Float:
    """`t` of each row: 0 in a start row, one more in each row after it."""
    row = np.arange(len(start), dtype=np.float64)
    last_start = np.maximum.accumulate(np.where(start, row, -1.0 - before))
    return row - last_start
