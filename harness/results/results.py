"""The results in an experiment's folder: compared combinations, cells, behaviour. Reads results only."""

import html
import importlib.util
from collections import Counter
from collections.abc import Iterable, Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

from harness.errors import UsageError
from harness.eta.curve import Kind
from harness.eta.equal import key_to_json
from harness.record.cell import Cell
from harness.record.manifest import Manifest
from harness.registry.given import read_given
from harness.registry.registry import load_registry
from harness.results.combine import combine
from harness.results.comparison import Comparison
from harness.results.overview import overview_html
from harness.results.recordings.places import PlaceStudy, studies_of
from harness.results.recordings.recording_results import numbers_in_environment
from harness.results.records import Records
from harness.results.table import Numbers, cell_to_json, metric_columns, numbers_of, table_of, write_table

FORMAT = 1
"""Of what reports say as JSON; docs/json.md explains it."""


class Results(Records):
    """An experiment, as its folder records it."""

    @cached_property
    def combinations(self) -> tuple[Comparison, ...]:
        """Every proposed reward against the baseline; in an environment also against one another.

        A baseline that is its own proposed reward is the null control.
        """
        if not self.is_in_environment:
            return combine(self)
        return tuple(comparison for place in self.studies if place.study for comparison in place.study.comparisons)

    @cached_property
    def studies(self) -> tuple[PlaceStudy, ...]:
        """Of an experiment in environments, the recorded trainings of each algorithm in each of them."""
        return studies_of(self)

    def to_json(self) -> dict[str, Any]:
        """Combinations and cells, plain data; see `harness.report.document` for all that a report says."""
        return {
            "format": FORMAT,
            "baseline": self.baseline,
            "curve": self.kind,
            "combinations": [combination.to_json() for combination in self.combinations],
            "cells": [{**cell_to_json(it), "task": it.cell.task.label} for it in self.manifests],
            "not_measured": self.not_measured,
            "equal_trainings": [
                {**group.to_json(), "trainings": [key_to_json(key) for key in keys]}
                for group, equal in self.equal.items()
                for keys in equal
            ],
        }

    def write_table(self) -> Path:
        """Write ``results.parquet``, one row per cell: every metric of its policy and of random actions.

        In an environment: what the policy did in its evaluation (``behaviour_success``), and what every reward paid for
        it (``return_own``), means over episodes.
        """
        return write_table(self.folder, self._rows(), metric_columns(self.metrics))

    def to_pandas(self) -> Any:
        """The table of `write_table` as a `pandas.DataFrame`, one row per cell.

        Raises:
            UsageError: pandas is not installed.
        """
        if importlib.util.find_spec("pandas") is None:
            raise UsageError("to_pandas needs pandas: pip install pandas")
        return table_of(self._rows(), metric_columns(self.metrics)).to_pandas()

    def __repr__(self) -> str:
        counts = Counter(manifest.status for manifest in self.manifests)
        ended = ", ".join(f"{count} {status}" for status, count in counts.items())
        return f"<Results of '{self.folder}': {len(self.manifests)} cells ({ended})>"

    def _repr_html_(self) -> str:
        """What a notebook shows: a line per comparison."""
        return overview_html(self.combinations) + f"<p>{html.escape(repr(self))}</p>"

    def _rows(self) -> Iterator[tuple[Manifest, Numbers | None]]:
        return ((it, self._numbers(it.cell) if it.status == "done" else None) for it in self.manifests)

    def _numbers(self, cell: Cell) -> Numbers:
        if cell.is_in_environment:
            return numbers_in_environment(self.folder, self.store.cell_folder(cell))
        return numbers_of(self.measured(cell), self.metrics)


def load_results(
    folder: str | Path,
    kind: Kind = "accumulated",
    metrics: Iterable[str] | str | None = None,
    plugins: Iterable[str | Path | type] = (),
) -> Results:
    """The results in an experiment's folder.

    Args:
        folder: The folder of the experiment.
        kind: Which curves the indices are read from; see `harness.eta.curve.GroupCurve`.
        metrics: Which metrics; every registered one if None, see `harness.results.metrics.load_metrics`.
        plugins: Files and classes beside the installed plugins; see `harness.registry.given.read_given`.

    Raises:
        UsageError: The folder is no experiment's, or a named metric is not registered.
        PluginError: A named metric is broken.
        SchemaError: A newer version wrote a file in it, or its plan is damaged and the cells do not tell either.
    """
    return Results(Path(folder), load_registry(given=read_given(plugins)), kind, metrics=metrics)
