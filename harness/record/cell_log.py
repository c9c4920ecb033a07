"""The traces that cells of an arm leave, as logs with the names that all logs share."""

from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq

from harness.log import Log
from harness.log.log import RECORDED, REWARD, START, TIME
from harness.record.cell import Cell, read_manifest
from harness.record.folder import MANIFEST, RANDOM, SUFFIX, TRACE, begun_by
from harness.record.trace import COLUMN, EVENTS, FORMAT_KEY, SCALARS, TERM, TraceWriter, read_trace

EXAMPLE_DOF = 2
APART = f"Events are paid on top of the reward, in the columns {', '.join(EVENTS)}"


@dataclass(frozen=True)
class CellLog:
    """A trace of a cell, ``trace.parquet`` or one of its evaluations.

    ``reward/LABEL`` and ``reward/LABEL/TERM`` are what the cell's own reward paid, without the events, which stand in
    columns of their own. All other columns have the names of `harness.record.trace`.
    """

    def recognises(self, path: Path, head: bytes) -> bool:
        """A Parquet file that says that it is a trace, and is no later part of another one."""
        if head.startswith(b"PAR1") and path.suffix == SUFFIX and not path.with_name(begun_by(path.name)).is_file():
            with suppress(Exception):  # whatever a damaged file does to its reader
                return FORMAT_KEY in (pq.read_schema(path).metadata or {})
        return False

    def read(self, path: Path) -> tuple[Log, ...]:
        """The one training or evaluation; the manifest beside it, if there is one, says of what."""
        log = cell_log(path)
        return (replace(log, facts=replace(log.facts, notes=(APART, *log.facts.notes))),)

    def write_example(self, folder: Path) -> Path:
        """Two episodes of two steps, each with its start row."""
        rows = np.zeros((6, len(SCALARS) + 2 * EXAMPLE_DOF))
        steps = np.tile([0.0, 1.0, 2.0], 2)
        told = {"episode": np.repeat([0, 1], 3), "step": steps, "begin_distance": 0.5, "distance": 0.5 - steps / 10}
        for name, values in {**told, "reward": steps / 4, "truncated": steps == 2}.items():
            rows[:, COLUMN[name]] = values
        with TraceWriter(folder / TRACE, EXAMPLE_DOF, EXAMPLE_DOF) as writer:
            writer.append(rows)
        return folder / TRACE


def cell_log(path: Path) -> Log:
    """A trace of a cell, as `CellLog` reads it.

    Raises:
        SchemaError: It is no trace that this version reads, or the manifest beside it is damaged.
    """
    trace, cell = read_trace(path), cell_of(path)
    label = cell.reward.label if cell else RECORDED
    paid = f"{REWARD}{label}"
    terms = {name: f"{paid}/{name.removeprefix(TERM)}" for name in trace.columns if name.startswith(TERM)}
    facts, is_training, is_random = trace.facts, path.name == TRACE, path.name == RANDOM
    if cell is not None:
        facts = replace(
            facts,
            env=cell.task.label,
            algorithm="random actions" if is_random else cell.algorithm.label,
            seed=cell.seed,
            trained_with="" if is_random else label,
            evaluation=not is_training,
            asked=cell.steps if is_training else 0,
        )
    log = replace(trace, facts=facts).renamed({"reward": paid, **terms})
    is_step = log["step"] > 0
    return log.add({START: ~is_step, TIME: np.cumsum(is_step)})


def cell_of(path: Path) -> Cell | None:
    """The cell that left a trace, if the manifest beside it says so."""
    return read_manifest(path.parent).cell if path.with_name(MANIFEST).is_file() else None
