"""What an experiment's folder says: combinations compared, cells, behaviour. Reads results only."""

from functools import cached_property
from itertools import repeat
from pathlib import Path
from typing import Any

from harness.eta.curve import Kind
from harness.registry.registry import load_registry
from harness.results.combination import Combination
from harness.results.combine import combine
from harness.results.records import Records
from harness.results.table import cell_to_json, row_of, write_table


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
            "cells": [cell_to_json(manifest) for manifest in self.manifests],
        }

    def write_table(self) -> Path:
        """Write ``results.parquet``, one row per cell: every metric of its policy and of random actions."""
        measured = [self.measured(it.cell) if it.status == "done" else None for it in self.manifests]
        rows = map(row_of, self.manifests, measured, repeat(self.metrics))
        return write_table(self.folder, rows, self.metrics)


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
