"""Pays a recorded run again under any reward, exactly as the learner would have been paid."""

from collections.abc import Callable, Collection, Iterable, Sequence

import numpy as np

from harness.arrays import Float, Mask
from harness.log import Log
from harness.reward import Array, Carry, MissingField, Paid, Reward, Sample, Steps, pay, put, take
from harness.reward.needs import reads_of
from harness.reward.row_steps import FIELDS, TOUCHED, Rows, RowSteps, field_rows, has_field, stretches_of
from harness.reward.steps import BEFORE, NOT_RECORDED, rows_of

SCORED = ("env", "step", "begin_distance", "previous_best", "distance", *TOUCHED)
"""Columns that a trace is scored from."""

BLOCK = 65_536
"""Rows are scored so many at a time: the columns of a block stay in the processor's cache."""


class Scorer:
    """Scores one run piece by piece. It remembers what the reward remembers, and the row before."""

    def __init__(self, reward: Reward) -> None:
        self._reward = reward
        self._carry: Carry = None
        self._steps = RowSteps()

    def pay(self, rows: Rows) -> Paid:
        """Shaped reward of the next rows and what each term of it paid, (rows,); 0 in the start rows.

        Raises:
            MissingField: The reward reads what is not recorded.
        """
        count = len(rows.distance)
        parts = [self._pay_block(rows.part(slice(first, first + BLOCK))) for first in range(0, count, BLOCK)]
        return parts[0] if len(parts) == 1 else joined(parts)

    def _pay_block(self, rows: Rows) -> Paid:
        steps, restart = self._steps.of(rows)
        empty = self._reward.initial_carry(steps.begin_distance[:1])
        if isinstance(empty, tuple) and not empty:  # remembers nothing: all rows at once
            paid = pay(self._reward, (), steps)[1]
        else:
            paid = self._pay_in_order(rows.start, restart, steps)
        return Paid(*_map_paid(paid, lambda value: np.where(rows.start, 0.0, np.asarray(value, np.float64))))

    def _pay_in_order(self, start: Mask, restart: Mask, steps: Steps) -> Paid:
        """Score a reward that remembers earlier rows: all targets of the block side by side, step by step."""
        row, ends = np.flatnonzero(_begins(restart)), np.append(np.flatnonzero(restart[1:]) + 1, len(start))
        carry = self._reward.initial_carry(steps.begin_distance[row])
        if self._carry is not None and not restart[0]:  # the first goes on from the block before
            carry = put(carry, np.array([0]), self._carry)
        total, terms = np.zeros(len(start)), dict[str, Float]()
        row = row + start[row]  # a start row is paid nothing, and remembered as no step
        while (running := row < ends).any():
            rows = row[running]
            after, paid = pay(self._reward, take(carry, running), rows_of(steps, rows))
            total[rows] = paid.total
            for name, value in paid.terms.items():
                terms.setdefault(name, np.zeros(len(start)))[rows] = value
            carry = put(carry, running, after)
            row = row + running
        self._carry = take(carry, np.array([len(ends) - 1]))
        return Paid(total, terms)


def score_trace(reward: Reward, trace: Log) -> Float:
    """The shaped reward of every row of a trace under `reward`, (rows,); see `pay_trace`."""
    total: Float = pay_trace(reward, trace).total
    return total


def pay_trace(reward: Reward, trace: Log) -> Paid:
    """The shaped reward of every row of a trace under `reward`, and its terms, (rows,), in the trace's order.

    Raises:
        MissingField: The reward reads what the trace does not have.
    """
    dof, size = (trace[name].shape[1] if name in trace else None for name in ("qpos", "action"))
    there = tuple(name for name in FIELDS if has_field(trace, name))
    fields = fields_beside_distances(reads_of(reward, there, dof, size))
    require_recorded(fields, there)
    try:
        return _pay_runs(reward, trace, fields)
    except MissingField:  # one that it reads in some steps alone, and not in made-up ones
        if set(FIELDS) <= {*fields}:
            raise
        return _pay_runs(reward, trace, FIELDS)


def fields_beside_distances(needs: Iterable[str]) -> tuple[str, ...]:
    """Which of `FIELDS` are among what a reward reads; for one of the step before its own name."""
    read = {name.removeprefix(f"{BEFORE}.") for name in needs}
    return tuple(name for name in FIELDS if name in read)


def require_recorded(fields: Iterable[str], recorded: Iterable[str]) -> None:
    """See that a run has what a reward reads beside distances.

    Args:
        fields: What it reads.
        recorded: Those of `FIELDS` that the run has.

    Raises:
        MissingField: The run lacks one.
    """
    there = tuple(recorded)
    for name in fields:
        if name not in there:
            told = (
                f"{name} is recorded where a reward of the experiment reads it: train in a new folder beside this one"
            )
            raise MissingField(
                name, (*Sample._fields, *there), "The recorded run", told if name in NOT_RECORDED else ""
            )


def _pay_runs(reward: Reward, trace: Log, fields: Collection[str]) -> Paid:
    rows, runs = field_rows(trace, fields), stretches_of(trace)
    if runs is None:
        return Scorer(reward).pay(rows)
    paid = joined([Scorer(reward).pay(rows.part(run)) for run in runs])
    back = np.argsort(np.concatenate(runs))
    return Paid(paid.total[back], {name: values[back] for name, values in paid.terms.items()})


def _map_paid(paid: Paid, function: Callable[[Array], Float]) -> tuple[Float, dict[str, Float]]:
    return function(paid.total), {name: function(value) for name, value in paid.terms.items()}


def joined(parts: Sequence[Paid]) -> Paid:
    """What steps are paid, of parts one after the other."""
    if not parts:
        return Paid(np.empty(0), {})
    terms = {name: np.concatenate([part.terms[name] for part in parts]) for name in parts[0].terms}
    return Paid(np.concatenate([part.total for part in parts]), terms)


def _begins(restart: Mask) -> Mask:
    """The first row of each target, or of the rest of a target."""
    begins = restart.copy()
    begins[0] = True
    return begins
