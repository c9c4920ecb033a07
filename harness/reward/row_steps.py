"""Rows of an arm's recorded run as the steps that a reward or a measure is given."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask, read_only
from harness.reward.steps import BEFORE, Sample, Steps, joined, rows_of, steps_of

TOUCHED = ("reached", "terminated", "truncated")
"""Columns of a trace that tell where a new target was set inside an episode."""
FIELDS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        **{name: (name,) for name in ("qpos", "qvel", "action", "ground")},
        **{name: tuple(f"{name}_{axis}" for axis in "xyz") for name in ("end_effector", "target")},
    }
)
"""The columns of each field of `harness.reward.steps.ARM` that a trace has beside the distances."""


class Recorded(Protocol):
    """Columns of an arm's recorded run by name, (rows, ...) each, such as those of a `harness.log.Log`."""

    def __getitem__(self, name: str) -> NDArray[Any]: ...

    def __contains__(self, name: object) -> bool: ...


@dataclass(frozen=True, eq=False)
class Rows:
    """Consecutive rows of one run, arrays of shape (rows,).

    Attributes:
        start: Whether the row is an episode's start, which is paid nothing.
        begin_distance: Bd, [m].
        previous_best: Pb before the step, [m].
        distance: d(t), [m].
        touched: Whether the target was reached and the next one set after the row; None where that is not recorded.
            Then a new target shows only in a new begin distance.
        more: Other fields of `harness.reward.steps.ARM` that are recorded, (rows, ...) each.
    """

    start: Mask
    begin_distance: Float
    previous_best: Float
    distance: Float
    touched: Mask | None = None
    more: Mapping[str, NDArray[Any]] = field(default_factory=dict)

    def part(self, rows: NDArray[np.int64] | Mask | slice) -> "Rows":
        """Some of them, in order."""
        return Rows(
            self.start[rows],
            self.begin_distance[rows],
            self.previous_best[rows],
            self.distance[rows],
            None if self.touched is None else self.touched[rows],
            {name: column[rows] for name, column in self.more.items()},
        )


class _Last(NamedTuple):
    """The values of the row before."""

    begin_distance: float
    distance: float
    step: float
    touched: bool
    more: Mapping[str, NDArray[Any]]


class RowSteps:
    """Makes steps of one run piece by piece. It remembers the row before."""

    def __init__(self) -> None:
        self._last = _Last(np.nan, np.nan, 0.0, False, {})

    def of(self, rows: Rows) -> tuple[Steps, Mask]:
        """The next rows as steps, and which of them begin an episode or have a new target, (rows,)."""
        restart = rows.start | self._has_new_target(rows)
        steps = self._steps(rows, restart)
        self._last = _last_of(rows, steps)
        return steps, restart

    def _has_new_target(self, rows: Rows) -> Mask:
        """Whether the target is another than in the row before, (rows,). Earlier distances belong to the old one."""
        begin = rows.begin_distance
        new: Mask = begin != np.concatenate([[self._last.begin_distance], begin[:-1]])
        if rows.touched is not None:  # the next target may be as far away as the last one was at first
            new |= np.concatenate([[self._last.touched], rows.touched[:-1]])
        return new

    def _steps(self, rows: Rows, restart: Mask) -> Steps:
        begin, best = read_only(rows.begin_distance), read_only(rows.previous_best)  # other rewards read them too
        distance = read_only(rows.distance)
        previous = np.where(restart, begin, np.concatenate([[self._last.distance], distance[:-1]]))
        step = _steps_since_start(rows.start, self._last.step)
        six = Sample(begin, best, previous, distance, distance - best, step)
        now = {name: read_only(column) for name, column in rows.more.items()}
        last = {**self._last.more, "distance": np.array([self._last.distance])}
        before = {
            name: read_only(np.concatenate([last.get(name, column[:1]), column[:-1]]))
            for name, column in {"distance": distance, **now}.items()
        }
        return steps_of({**six._asdict(), **now, BEFORE: steps_of(before)})


def targets_touched(reached: Mask, terminated: Mask, truncated: Mask) -> Mask:
    """Where a target was reached and the episode went on to the next one, (rows,)."""
    touched: Mask = reached & ~(terminated | truncated)
    return touched


def has_field(run: Recorded, name: str) -> bool:
    """Whether a run recorded a field of steps; distances it always has."""
    return all(column in run for column in FIELDS.get(name, ()))


def field_rows(run: Recorded, fields: Collection[str]) -> Rows:
    """The rows that steps are made of, with those of `FIELDS` that are asked for and recorded."""
    more = {name: _field(run, name) for name in FIELDS if name in fields and has_field(run, name)}
    touched = targets_touched(*(run[name] for name in TOUCHED)) if all(name in run for name in TOUCHED) else None
    return Rows(_starts(run), run["begin_distance"], run["previous_best"], run["distance"], touched, more)


def steps_of_run(run: Recorded, fields: Collection[str]) -> Steps:
    """Every row as a step that a reward or a measure is given, in the run's order.

    Args:
        run: The run.
        fields: Which of `FIELDS` steps have beside the distances, where they are recorded.
    """
    rows, stretches = field_rows(run, fields), stretches_of(run)
    if stretches is None:
        return RowSteps().of(rows)[0]
    steps = joined([RowSteps().of(rows.part(stretch))[0] for stretch in stretches])
    return rows_of(steps, np.argsort(np.concatenate(stretches)))


def stretches_of(run: Recorded) -> list[NDArray[np.int64]] | None:
    """Row numbers of each stretch of rows that follow one another; None where all rows do, in their order.

    A new one begins at an env that does not begin with a start row. Rows after a start row do not depend on rows before
    it, so several envs can be one stretch. For the 100 envs of an evaluation a reward then takes a fifth of the time of
    100 stretches, and less if it has a memory.
    """
    env = run["env"]
    if (env[1:] == env[:-1]).all():
        return None
    order = np.argsort(env, kind="stable")
    is_next = np.diff(env[order]) != 0
    return np.split(order, np.flatnonzero(is_next & ~_starts(run)[order][1:]) + 1)


def _starts(run: Recorded) -> Mask:
    """Which rows are starts: as the run says it, or by a step of 0."""
    start: Mask = run["start"] if "start" in run else run["step"] == 0
    return start


def _field(run: Recorded, name: str) -> NDArray[Any]:
    columns = [run[column] for column in FIELDS[name]]
    return columns[0] if len(columns) == 1 else np.stack(columns, axis=1)


def _last_of(rows: Rows, steps: Steps) -> _Last:
    touched = rows.touched is not None and bool(rows.touched[-1])
    more = {name: column[-1:].copy() for name, column in rows.more.items()}
    return _Last(float(rows.begin_distance[-1]), float(rows.distance[-1]), float(steps.step[-1]), touched, more)


def _steps_since_start(start: Mask, before: float) -> Float:
    """`t` of each row: 0 in a start row, one more in each row after it."""
    row = np.arange(len(start), dtype=np.float64)
    last_start = np.maximum.accumulate(np.where(start, row, -1.0 - before))
    return row - last_start
