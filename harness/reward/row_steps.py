"""Rows of an arm's recorded run as the steps that a reward or a measure is given."""

from collections.abc import Collection, Mapping
from types import MappingProxyType
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Ints, Mask, read_only
from harness.reward.steps import ENDS, Steps, rows_of, step_between

TOUCHED = ("reached", *ENDS)
"""Columns of a trace that tell where a new target was set inside an episode."""
DISTANCES = ("begin_distance", "previous_best", "distance")
"""Columns that every log has that can be paid again; besides them ``start``, or ``step``, which is 0 in start rows."""
FIELDS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        **{name: (name,) for name in ("qpos", "qvel", "action", "ground", *ENDS)},
        **{name: tuple(f"{name}_{axis}" for axis in "xyz") for name in ("end_effector", "target")},
    }
)
"""The columns of each field of `harness.reward.steps.ARM` that a trace has beside the distances."""
Rows: TypeAlias = Mapping[str, NDArray[Any]]
"""Consecutive rows of one run, (rows, ...) each: ``start``, whether the row is an episode's start, which is paid
nothing; `DISTANCES`; those of `FIELDS` that are recorded and wanted; ``touched``, whether the target was reached and
the next one set after the row, without which a new target shows only in a new begin distance; and in rows of several
envs, one env after the other, ``first``, whether the row is the first one of another env."""


class Recorded(Protocol):
    """Columns of an arm's recorded run by name, (rows, ...) each, such as those of a `harness.log.Log`."""

    def __getitem__(self, name: str) -> NDArray[Any]: ...

    def __contains__(self, name: object) -> bool: ...


def part_of(rows: Rows, which: Ints | slice) -> Rows:
    """Some rows, in order."""
    return {name: column[which] for name, column in rows.items()}


def steps_of_rows(rows: Rows, last: Rows | None = None) -> tuple[Steps, Mask, Rows]:
    """The next rows of a run as steps; which of them begin an episode or have a new target, (rows,); the last of them.

    Args:
        rows: They.
        last: The last row of those before them, as this returned it; nothing before the first ones.
    """
    last = last or {"begin_distance": np.array([np.nan]), "distance": np.array([np.nan]), "step": np.zeros(1)}
    rows = {name: read_only(column) for name, column in rows.items()}  # other rewards read them too
    start, begin, best, distance = (rows[name] for name in ("start", *DISTANCES))
    before = {
        name: np.concatenate([last.get(name, column[:1]), column[:-1]])
        for name, column in rows.items()
        if name not in ("start", "previous_best", "first")
    }
    first = rows.get("first", np.zeros(1, bool))
    if first.any():
        for name, column in before.items():
            column[first] = np.nan if name in DISTANCES else rows[name][first]
    before = {name: read_only(column) for name, column in before.items()}
    # The next target may be as far away as the last one was at first. Earlier distances belong to the old one.
    restart: Mask = start | (begin != before.pop("begin_distance")) | before.pop("touched", np.False_)
    row = np.arange(len(start), dtype=np.float64)
    step = row - np.maximum.accumulate(np.where(start, row, np.where(first, row, -last["step"]) - 1.0))
    after = {"distance": distance, **{name: rows[name] for name in FIELDS if name in rows}}
    steps = step_between(before, after, begin, best, step, np.where(restart, begin, before["distance"]))
    ends = {name: column[-1:].copy() for name, column in {**rows, "step": step}.items()}
    return steps, restart, ends


def has_field(run: Recorded, name: str) -> bool:
    """Whether a run recorded a field of steps; distances it always has."""
    return all(column in run for column in FIELDS.get(name, ()))


def field_rows(run: Recorded, fields: Collection[str]) -> Rows:
    """The rows that steps are made of, with those of `FIELDS` that are asked for and recorded."""
    start = run["start"] if "start" in run else run["step"] == 0
    rows = {"start": start, **{name: run[name] for name in DISTANCES}}
    if all(name in run for name in TOUCHED):
        rows["touched"] = run["reached"] & ~(run["terminated"] | run["truncated"])
    for name in FIELDS:
        if name in fields and has_field(run, name):
            columns = [run[column] for column in FIELDS[name]]
            rows[name] = columns[0] if len(columns) == 1 else np.stack(columns, axis=1)
    return rows


def steps_of_run(run: Recorded, fields: Collection[str]) -> Steps:
    """Every row as a step that a reward or a measure is given, in the run's order.

    Args:
        run: The run.
        fields: Which of `FIELDS` steps have beside the distances, where they are recorded.
    """
    rows, order = by_env(field_rows(run, fields), run["env"])
    steps = steps_of_rows(rows)[0]
    return steps if order is None else rows_of(steps, np.argsort(order))


def by_env(rows: Rows, env: NDArray[Any]) -> tuple[Rows, Ints | None]:
    """All rows of a run, one env after the other, and the number that each had before; None if that is its own."""
    if (env[1:] == env[:-1]).all():
        return rows, None
    order = np.argsort(env, kind="stable")
    return {**part_of(rows, order), "first": np.diff(env[order], prepend=env[order[0]]) != 0}, order
