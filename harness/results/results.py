"""The results in an experiment's folder: compared combinations, cells, behaviour. Reads results only."""

import html
import importlib.util
from collections import Counter
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import pyarrow as pa

from harness.errors import UsageError
from harness.eta.equal import key_to_json
from harness.record.cell import Cell
from harness.record.manifest import Manifest
from harness.results.alone import Alone, alone_in
from harness.results.combine import combine
from harness.results.comparison import Comparison, pools_of
from harness.results.frames import Frames
from harness.results.learning import Learning, learning_of
from harness.results.overview import overview_html
from harness.results.pool import Pool
from harness.results.records import Records
from harness.results.return_matrix import ReturnMatrix, return_matrices
from harness.results.rows import comparison_rows
from harness.results.table import Numbers, cell_to_json, metric_columns, numbers_of, table_of, write_table
from harness.results.terms_paid import TermsPaid, terms_of_cells

FORMAT = 1
"""The version of what reports say as JSON; docs/json.md explains it."""


class Results(Records):
    """The cells of an experiment that trained an arm; `harness.results.recordings.results` has those of environments.

    Attributes:
        subject: What behaves, in words.
    """

    subject: ClassVar[str] = "robot"

    @cached_property
    def combinations(self) -> tuple[Comparison, ...]:
        """Every proposed reward against the baseline, or every two rewards where `pairs` was asked for.

        A baseline that is its own proposed reward is the null control.
        """
        return combine(self)

    @property
    def pools(self) -> tuple[Pool, ...]:
        """One answer for each reward over all places in which it trained, where there are several."""
        return pools_of(self.combinations)

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """What to keep in mind of the trainings, a line each."""
        return ()

    @property
    def said(self) -> tuple[str, ...]:
        """How what was found was sorted and read, a line each: what to know before the first number."""
        return ()

    @property
    def damaged_recordings(self) -> tuple[str, ...]:
        """Recordings that could not be read, a line each; a cell with a damaged file is among `damaged` instead."""
        return ()

    @cached_property
    def returns(self) -> tuple[ReturnMatrix, ...]:
        """What each reward would have paid the policies that each reward trained.

        Raises:
            SchemaError: A file is damaged or written by a newer version.
        """
        return tuple(return_matrices(self))

    @cached_property
    def terms(self) -> tuple[TermsPaid, ...]:
        """What each term of each reward paid, of the rewards that have terms.

        Raises:
            SchemaError: A file is damaged or written by a newer version.
        """
        return terms_of_cells(self)

    @cached_property
    def alone(self) -> tuple[Alone, ...]:
        """What each reward paid for that no other stands beside, so that nothing compares it.

        Raises:
            SchemaError: A file is damaged or written by a newer version.
        """
        return alone_in(self)

    def learning(self, combination: Comparison) -> Learning | None:
        """How the policies of a combination behaved while they learned; None if that is not known.

        Raises:
            SchemaError: A file is damaged or written by a newer version.
        """
        return learning_of(self, combination)

    def frames(self, cell: Cell) -> Frames | None:
        """Pictures of an evaluation episode that an environment drew; None of an arm, which has a replay."""
        return None

    def older_keys(self) -> dict[str, Any]:
        """What a report says as JSON for readers of version 0.1 alone; these keys leave with the next format."""
        return {}

    def to_json(self) -> dict[str, Any]:
        """Combinations and cells, plain data; see `harness.report.document` for all that a report says."""
        return {
            "format": FORMAT,
            "baseline": self.baseline,
            "curve": self.kind,
            "combinations": [combination.to_json() for combination in self.combinations],
            "over_places": [pool.to_json() for pool in self.pools],
            "terms": self.plan.terms.to_json(),
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
        return _data_frame(table_of(self._rows(), metric_columns(self.metrics)), "to_pandas")

    def comparisons(self) -> Any:
        """A `pandas.DataFrame` with a row per comparison: the answer, its test, what decides, and the numbers.

        `harness.results.rows.comparison_rows` makes the same as a table of pyarrow, which needs no pandas.

        Raises:
            UsageError: pandas is not installed.
        """
        return _data_frame(comparison_rows(self.combinations), "comparisons")

    def __repr__(self) -> str:
        counts = Counter(manifest.status for manifest in self.manifests)
        ended = ", ".join(f"{count} {status}" for status, count in counts.items())
        return f"<Results of '{self.folder}': {len(self.manifests)} cells ({ended})>"

    def _repr_html_(self) -> str:
        """What a notebook shows: a line per comparison."""
        return overview_html(self.combinations) + f"<p>{html.escape(repr(self))}</p>"

    def _rows(self) -> Iterator[tuple[Manifest, Numbers | None]]:
        return ((it, self.numbers(it.cell) if it.status == "done" else None) for it in self.manifests)

    def numbers(self, cell: Cell) -> Numbers:
        """The numbers of a done cell, in the columns of `write_table`."""
        return numbers_of(self.measured(cell), self.metrics)


def _data_frame(table: pa.Table, asked: str) -> Any:
    if importlib.util.find_spec("pandas") is None:
        raise UsageError(f"{asked} needs pandas: pip install pandas")
    return table.to_pandas()
