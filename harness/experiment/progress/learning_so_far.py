"""Results of the last episodes of a training while it goes on."""

import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from harness.arrays import Float
from harness.executor import NO_SCALARS
from harness.progress import LAST_EPISODES, RETURN, SPEED, SUCCESS, TERMS
from harness.record.returns import PAID
from harness.record.trace import COLUMN, SCALARS, Recorder, Rows

ENV, EPISODE, STEP = (COLUMN[name] for name in ("env", "episode", "step"))
PAYMENTS = [COLUMN[name] for name in PAID]
REACHED, ENDS = COLUMN["reached"], [COLUMN["terminated"], COLUMN["truncated"]]
TELL_EVERY = 1.0
"""Seconds."""


class LearningSoFar:
    """A `Recorder` that hands every row on, and knows what the last `LAST_EPISODES` episodes came to.

    A step costs a copy of its rows. They are added up when somebody asks, or when there are `BLOCK` of them.
    Episodes that were under way when a killed training went on are left out.
    """

    BLOCK = 4096

    def __init__(
        self,
        recorder: Recorder,
        begun_from: int = 0,
        now: Callable[[], float] = time.monotonic,
        terms: Sequence[str] = (),
    ) -> None:
        """Start before any episode has ended.

        Args:
            recorder: Gets the rows.
            begun_from: Environment steps that were done before.
            now: The time, [s].
            terms: Of the reward, whose columns end each row.
        """
        self._recorder, self._now, self._terms = recorder, now, [f"{TERMS}/{name}" for name in terms]
        self._block, self._filled = np.empty((self.BLOCK, len(SCALARS) + len(terms))), 0
        # By env: the episode, what it was paid, the total and then its terms, and whether it reached.
        self._open: dict[int, tuple[int, Float, bool]] = {}
        self._ended: deque[tuple[Float, bool]] = deque(maxlen=LAST_EPISODES)
        self._steps, self._told = begun_from, now()

    def append(self, rows: Rows) -> None:
        """See `harness.record.trace.Recorder`."""
        self._recorder.append(rows)
        for first in range(0, len(rows), self.BLOCK):
            part = rows[first : first + self.BLOCK]
            if self._filled + len(part) > self.BLOCK:
                self._add_up()
            place = self._block[self._filled : self._filled + len(part)]
            place[:, : len(SCALARS)] = part[:, : len(SCALARS)]
            if self._terms:
                place[:, len(SCALARS) :] = part[:, -len(self._terms) :]
            self._filled += len(part)

    def scalars_if_due(self, steps: int) -> Mapping[str, float]:
        """`scalars`, once in `TELL_EVERY` seconds; else nothing."""
        return self.scalars(steps) if self._now() >= self._told + TELL_EVERY else NO_SCALARS

    def scalars(self, steps: int) -> dict[str, float]:
        """The scalars after `steps`, by the names of `harness.progress`; empty if they were reported before."""
        if steps == self._steps:
            return {}
        self._add_up()
        now = self._now()
        found = {}
        if now > self._told:
            found[SPEED] = (steps - self._steps) / (now - self._told)
        self._steps, self._told = steps, now
        if self._ended:
            paid, reached = zip(*self._ended, strict=True)
            total, *terms = (sum(paid) / len(paid)).tolist()
            found |= {SUCCESS: sum(reached) / len(reached), RETURN: total, **dict(zip(self._terms, terms, strict=True))}
        return found

    def _add_up(self) -> None:
        rows = self._block[: self._filled]
        self._filled = 0
        keys = rows[:, ENV].astype(np.int64) << 32 | rows[:, EPISODE].astype(np.int64)
        episodes, where = np.unique(keys, return_inverse=True)  # by env, and in order
        columns = (rows[:, PAYMENTS].sum(axis=1), *rows[:, len(SCALARS) :].T)
        paid = np.stack([np.bincount(where, column, len(episodes)) for column in columns], axis=1)
        reached = np.bincount(where, rows[:, REACHED], len(episodes)) > 0
        begins = np.bincount(where, rows[:, STEP] == 0, len(episodes)) > 0
        last_rows = np.full(len(episodes), -1)
        ends = np.flatnonzero(rows[:, ENDS].any(axis=1))
        last_rows[where[ends]] = ends
        ended, nothing = list[tuple[int, tuple[Float, bool]]](), np.zeros(len(columns))
        for index, key in enumerate(episodes.tolist()):
            env, episode = divmod(key, 2**32)
            number, before, was_reached = (
                (episode, nothing, False) if begins[index] else self._open.get(env, (-1, nothing, False))
            )
            if number != episode:
                continue
            total = episode, before + paid[index], was_reached or bool(reached[index])
            if last_rows[index] < 0:
                self._open[env] = total
            else:
                self._open.pop(env, None)
                ended.append((int(last_rows[index]), total[1:]))
        self._ended.extend(episode for _, episode in sorted(ended, key=lambda it: it[0]))
