"""Pays a recorded run again under any reward, exactly as the learner would have been paid."""

from collections import defaultdict
from collections.abc import Iterable, Iterator
from contextlib import chdir
from functools import partial
from typing import TypeAlias

import numpy as np

from harness.arrays import Float, Ints, Mask
from harness.errors import UsageError
from harness.log import Log, Rows
from harness.log.log import RECORDED, REWARD
from harness.reward import (
    Carry,
    Paid,
    Reward,
    Sample,
    Steps,
    pay,
)
from harness.reward.reward import put, take
from harness.reward.row_steps import (
    DISTANCES,
    FIELDS,
    TOUCHED,
    Rows as StepRows,
    by_env,
    field_rows,
    has_field,
    part_of,
    steps_of_rows,
)
from harness.reward.steps import BEFORE, NOT_RECORDED, MissingField, rows_of
from harness.reward.terms import shown_needs

SCORED = ("env", "step", *DISTANCES, *TOUCHED)
"""Columns that a trace is scored from."""

PIECE = 2**18
"""Rows of a log are read so many at a time."""
Part: TypeAlias = tuple[Ints | slice, Paid]
"""Numbers of some rows, and what they are paid."""
BLOCK = 65_536
"""Rows are scored so many at a time: the columns of a block stay in the processor's cache."""


class Scorer:
    """Scores one run piece by piece. It remembers what the reward remembers, and the row before."""

    def __init__(self, reward: Reward) -> None:
        self._reward = reward
        self._carry: Carry = None
        self._last: StepRows = {}

    def pay(self, rows: StepRows) -> Paid:
        """Shaped reward of the next rows and what each term of it paid, (rows,); 0 in the start rows.

        Raises:
            MissingField: The reward reads what is not recorded.
        """
        blocks = (slice(first, first + BLOCK) for first in range(0, len(rows["start"]), BLOCK))
        return _placed(((block, self._pay_block(part_of(rows, block))) for block in blocks), len(rows["start"]))

    def _pay_block(self, rows: StepRows) -> Paid:
        steps, restart, self._last = steps_of_rows(rows, self._last)
        start, empty = rows["start"], self._reward.initial_carry(steps.begin_distance[:1])
        if isinstance(empty, tuple) and not empty:  # remembers nothing: all rows at once
            paid = pay(self._reward, (), steps)[1]
        else:
            paid = _placed(self._pay_in_order(start, restart, steps), len(start))
        values = (paid.total, *paid.terms.values())
        total, *terms = (np.where(start, 0.0, np.asarray(it, np.float64)) for it in values)
        return Paid(total, dict(zip(paid.terms, terms, strict=True)))

    def _pay_in_order(self, start: Mask, restart: Mask, steps: Steps) -> Iterator[Part]:
        """Score a reward that remembers earlier rows: all targets of the block side by side, step by step."""
        row = np.union1d(0, np.flatnonzero(restart))  # the first row begins a stretch too
        ends = np.append(row[1:], len(start))
        carry = self._reward.initial_carry(steps.begin_distance[row])
        if self._carry is not None and not restart[0]:  # the first goes on from the block before
            carry = put(carry, np.array([0]), self._carry)
        row = row + start[row]  # a start row is paid nothing, and remembered as no step
        while (running := row < ends).any():
            rows = row[running]
            after, paid = pay(self._reward, take(carry, running), rows_of(steps, rows))
            yield rows, paid
            carry = put(carry, running, after)
            row = row + running
        self._carry = take(carry, np.array([len(ends) - 1]))


def _placed(parts: Iterable[Part], rows: int) -> Paid:
    """What all rows are paid, of parts that tell it of some of them; 0 where none does."""
    total, terms = np.zeros(rows), dict[str, Float]()
    for where, paid in parts:
        total[where] = paid.total
        for name, values in paid.terms.items():
            terms.setdefault(name, np.zeros(rows))[where] = values
    return Paid(total, terms)


class Payer:
    """Pays a log piece by piece. Envs that trained together are runs of their own.

    Attributes:
        columns: What pieces have to have.
    """

    def __init__(self, reward: Reward, log: Log, *, with_all: bool = False) -> None:
        """Pay nothing yet.

        Args:
            reward: The reward.
            log: A log that `can_be_paid`.
            with_all: Whether the reward is given all that is recorded, whatever it was seen to read.

        Raises:
            MissingField: The reward reads what is not recorded.
        """
        there = tuple(name for name in FIELDS if has_field(log, name))
        sized = [name for name in ("qpos", "action") if name in log]
        head = next(log.pieces(sized, 1), Rows({}))
        sizes = (head[name].shape[1] if name in head else None for name in ("qpos", "action"))
        needs = None if with_all else shown_needs(reward, *sizes)
        self._fields = there if needs is None else fields_beside_distances(needs.fields)
        for name in (it for it in self._fields if it not in there):
            told = "where a reward of the experiment reads it: train in a new folder beside this one"
            hint = f"{name} is recorded {told}" if name in NOT_RECORDED else ""
            raise MissingField(name, (*Sample._fields, *there), "The recorded run", hint)
        flags = TOUCHED if all(name in log for name in TOUCHED) else ()
        start = "start" if "start" in log else "step"
        self.columns = ("env", start, *DISTANCES, *flags, *(it for name in self._fields for it in FIELDS[name]))
        self.has_all = set(there) <= {*self._fields}
        self._scorers = defaultdict[int, Scorer](partial(Scorer, reward))

    def pay(self, piece: Rows, *, is_whole: bool = False) -> Paid:
        """Shaped reward of the next rows and what each term of it paid, (rows,); 0 in the start rows.

        Args:
            piece: The rows.
            is_whole: Whether they are all rows of the log.

        Raises:
            MissingField: The reward reads what is not recorded.
        """
        rows, env = field_rows(piece, self._fields), piece["env"]
        with np.errstate(all="ignore"):  # a reward may divide by anything where it then takes another value
            if is_whole or (env == env[0]).all():
                rows, order = by_env(rows, env)
                paid = self._scorers[int(env[0])].pay(rows)
                return paid if order is None else _placed([(order, paid)], len(env))
            runs = (np.flatnonzero(env == number) for number in np.unique(env))
            return _placed(((run, self._scorers[int(env[run[0]])].pay(part_of(rows, run))) for run in runs), len(env))


def pay_column(log: Log) -> str:
    """The column of what each step was paid.

    Raises:
        UsageError: It has none.
    """
    names = ("reward", *(f"{REWARD}{name}" for name in (RECORDED, log.facts.trained_with, *log.rewards)))
    for name in names:
        if name in log:
            return name
    raise UsageError(f"{log.facts.path} does not tell what a step was paid")


def can_be_paid(log: Log) -> bool:
    """Whether it has the distances that a reward of an arm is computed from."""
    return all(name in log for name in ("env", *DISTANCES)) and ("start" in log or "step" in log)


def pay_log(reward: Reward, log: Log, *, with_all: bool = False) -> Paid:
    """The shaped reward of every row of a log that `can_be_paid` and its terms, (rows,), in the log's order.

    A reward that reads more in some steps than in made-up ones is called again with all that is recorded.

    Raises:
        MissingField: The reward reads what the log does not have.
    """
    payer = Payer(reward, log, with_all=with_all)
    try:
        pieces = log.pieces([*DISTANCES, *payer.columns], PIECE)
        paid = ((slice(it.first, it.first + len(it)), payer.pay(it, is_whole=len(it) == len(log))) for it in pieces)
        with chdir("."):  # the reward may change it
            return _placed(paid, len(log))
    except MissingField:
        if payer.has_all:
            raise
        return pay_log(reward, log, with_all=True)


def fields_beside_distances(needs: Iterable[str]) -> tuple[str, ...]:
    """Which of `FIELDS` are among what a reward reads; for one of the step before its own name."""
    read = {name.removeprefix(f"{BEFORE}.") for name in needs}
    return tuple(name for name in FIELDS if name in read)
