"""What an experiment's folder says: combinations compared, cells, behaviour. Reads results only."""

from functools import cached_property
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from harness.eta.curve import Kind
from harness.files.sums import note_made
from harness.files.whole_file import whole_file
from harness.record.manifest import Manifest
from harness.record.store import RESULTS
from harness.registry.registry import load_registry
from harness.results.combination import Combination
from harness.results.combine import combine
from harness.results.records import Records


class Results(Records):
    """An experiment as its folder tells it."""

    @cached_property
    def combinations(self) -> tuple[Combination, ...]:
        """Every proposed reward against the baseline; a baseline that is its own proposed reward is the control."""
        return combine(self)

    def to_json(self) -> dict[str, Any]:
        """Combinations and cells, plain data; see `harness.report.document` for all that a report says."""
        return {
            "curve": self.kind,
            "combinations": [combination.to_json() for combination in self.combinations],
            "cells": [_cell_to_json(manifest) for manifest in self.manifests],
        }

    def write_table(self) -> Path:
        """Write ``results.parquet``, one row per cell: every metric of its policy and of random actions."""
        names = [prefix + name for prefix in ("", "random_") for name in self.metrics]
        rows = [self._row(manifest) for manifest in self.manifests]
        path = self.folder / RESULTS
        table = pa.Table.from_pylist(rows)
        numbers = {name: table.schema.get_field_index(name) for name in names}
        for name, index in numbers.items():  # a column without a value would have no type
            table = table.set_column(index, name, table.column(name).cast(pa.float64()))
        with whole_file(path) as partial:
            pq.write_table(table, partial)
        note_made(path)
        return path

    def _row(self, manifest: Manifest) -> dict[str, Any]:
        measured = self.measured(manifest.cell) if manifest.status == "done" else None
        return {
            **_cell_to_json(manifest),
            "robot": manifest.cell.robot,
            "task": manifest.cell.task.label,
            **{name: measured and measured.own[name] for name in self.metrics},
            **{f"random_{name}": measured and measured.random[name] for name in self.metrics},
        }


def load_results(folder: str | Path, kind: Kind = "accumulated") -> Results:
    """The results in an experiment's folder.

    Args:
        folder: The experiment's.
        kind: Which curves the indices are read from; see `harness.eta.curve.GroupCurve`.

    Raises:
        UsageError: The folder is no experiment's.
        SchemaError: A newer version wrote a file in it, or its plan is damaged and the cells do not tell either.
    """
    return Results(Path(folder), load_registry(), kind)


def _cell_to_json(manifest: Manifest) -> dict[str, Any]:
    cell = manifest.cell
    return {
        "id": cell.id,
        "simulator": cell.simulator.label,
        "algorithm": cell.algorithm.label,
        "reward": cell.reward.label,
        "seed": cell.seed,
        "status": manifest.status,
        "reason": manifest.reason,
        "seconds": manifest.seconds,
        "steps": cell.steps,
    }
