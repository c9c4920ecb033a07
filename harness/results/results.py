"""What an experiment's folder says: combinations compared, cells, behaviour. Reads results only."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from harness.eta.behaviour_change import Change, change_of
from harness.eta.curve import GroupCurve, curve_of
from harness.eta.decompose import BB, BK, KB, KK, Pair, decompose
from harness.eta.statistics import holm
from harness.metric import Metric
from harness.record.cell import Cell
from harness.record.folder import EVALUATION, RANDOM, TRACE
from harness.record.manifest import Manifest
from harness.record.store import RESULTS, Store
from harness.record.trace import Trace, read_trace
from harness.record.whole_file import whole_file
from harness.registry.choice import Choice, build_defaults
from harness.registry.registry import Registry, load_registry
from harness.results.combination import Combination, Group
from harness.score.scored_runs import score_runs
from harness.score.scorer import SCORED

Values = dict[str, float | None]
"""By metric; None where it is not defined."""
CORRECTED = ("eta_n", "eta_p", "success")


class Results:
    """An experiment as its folder tells it."""

    def __init__(self, folder: Path, registry: Registry) -> None:
        self.folder = folder
        self.store = Store.open(folder)
        self.registry = registry
        self.baseline, self._a_a, planned = self.store.read_plan()
        ended = {manifest.cell.id: manifest for manifest in self.store.manifests()}
        self.manifests = [
            ended.get(cell.id) or Manifest(cell, status="pending", reason="not run yet") for cell in planned
        ]

    @cached_property
    def metrics(self) -> dict[str, Metric]:
        """Every registered metric, by name."""
        return build_defaults(self.registry, "metrics")

    @cached_property
    def evaluations(self) -> dict[str, Values]:
        """By cell id: every metric of the trained policy, and with ``random_`` before it of random actions."""
        return {manifest.cell.id: self._evaluate(manifest.cell) for manifest in self._done}

    @cached_property
    def combinations(self) -> tuple[Combination, ...]:
        """Every proposed reward against the baseline; a baseline that is its own proposed reward is A/A."""
        compared = dict.fromkeys(
            (Group.of(manifest.cell), manifest.cell.reward)
            for manifest in self.manifests
            if (manifest.cell.reward.label != self.baseline or self._a_a) and manifest.status != "skipped"
        )
        return _correct([self._combine(group, reward) for group, reward in compared])

    def measure(self, trace: Trace) -> Values:
        """Every metric of an evaluation."""
        return {name: metric(trace) for name, metric in self.metrics.items()}

    @property
    def failed(self) -> list[Manifest]:
        """Cells that failed."""
        return [manifest for manifest in self.manifests if manifest.status == "failed"]

    @property
    def done_cells(self) -> list[Cell]:
        """Cells that left a trace."""
        return [manifest.cell for manifest in self._done]

    def to_json(self) -> dict[str, Any]:
        """Combinations and cells, plain data; see `harness.report.document` for all that a report says."""
        return {
            "combinations": [combination.to_json() for combination in self.combinations],
            "cells": [_cell_to_json(manifest) for manifest in self.manifests],
        }

    def write_table(self) -> Path:
        """Write ``results.parquet``, one row per cell with every metric."""
        names = [prefix + name for prefix in ("", "random_") for name in self.metrics]
        rows = [
            {
                **_cell_to_json(manifest),
                "robot": manifest.cell.robot,
                "task": manifest.cell.task.label,
                **{name: self.evaluations.get(manifest.cell.id, {}).get(name) for name in names},
            }
            for manifest in self.manifests
        ]
        path = self.folder / RESULTS
        table = pa.Table.from_pylist(rows)
        numbers = {name: table.schema.get_field_index(name) for name in names}
        for name, index in numbers.items():  # a column without a value would have no type
            table = table.set_column(index, name, table.column(name).cast(pa.float64()))
        with whole_file(path) as partial:
            pq.write_table(table, partial)
        return path

    @property
    def _done(self) -> list[Manifest]:
        return [manifest for manifest in self.manifests if manifest.status == "done"]

    def _evaluate(self, cell: Cell) -> Values:
        folder = self.store.cell_folder(cell)
        trained, random = (self.measure(read_trace(folder / file)) for file in (EVALUATION, RANDOM))
        return {**trained, **{f"random_{name}": value for name, value in random.items()}}

    def _combine(self, group: Group, proposed: Choice) -> Combination:
        members = [manifest.cell for manifest in self._done if Group.of(manifest.cell) == group]
        by_seed_b = {cell.seed: cell for cell in members if cell.reward.label == self.baseline}
        by_seed_k = {cell.seed: cell for cell in members if cell.reward == proposed}
        seeds = tuple(sorted(by_seed_b.keys() & by_seed_k.keys()))
        if not seeds:
            return Combination(group, self.baseline, proposed.label, (), None, (), {})
        cells_b, cells_k = [by_seed_b[seed] for seed in seeds], [by_seed_k[seed] for seed in seeds]
        curves, missing = self._score(cells_b, cells_k)
        changes = tuple(self._change(name, metric, cells_b, cells_k) for name, metric in self.metrics.items())
        split = decompose(curves, missing=missing)
        return Combination(group, self.baseline, proposed.label, seeds, split, changes, curves)

    def _score(self, baseline: list[Cell], proposed: list[Cell]) -> tuple[dict[Pair, GroupCurve], str | None]:
        """The curves of both trainings under both rewards; under their own alone, with the reason, if need be."""
        traces_b, traces_k = self._traces(baseline), self._traces(proposed)
        curves = {BB: _recorded_curve(traces_b), KK: _recorded_curve(traces_k)}
        by_b = score_runs(baseline[0].reward, self.registry, traces_b[0], traces_k)
        by_k = score_runs(proposed[0].reward, self.registry, traces_k[0], traces_b)
        if by_b.values is None or by_k.values is None:
            return curves, by_b.reason or by_k.reason
        return {**curves, BK: curve_of(by_b.values), KB: curve_of(by_k.values)}, None

    def _traces(self, cells: list[Cell]) -> list[Trace]:
        return [read_trace(self.store.cell_folder(cell) / TRACE, [*SCORED, "reward"]) for cell in cells]

    def _change(self, name: str, metric: Metric, baseline: list[Cell], proposed: list[Cell]) -> Change:
        def values(cells: Sequence[Cell], column: str) -> list[float | None]:
            return [self.evaluations[cell.id][column] for cell in cells]

        random = values([*baseline, *proposed], f"random_{name}")
        return change_of(name, metric.unit, metric.better, values(baseline, name), values(proposed, name), random)


def load_results(folder: str | Path) -> Results:
    """The results in an experiment's folder.

    Raises:
        UsageError: The folder is no experiment's.
        SchemaError: A file in it is damaged or written by a newer version.
    """
    return Results(Path(folder), load_registry())


def _pending(cell: Cell) -> Manifest:
    return Manifest(cell, status="pending", reason="not run yet")


def _recorded_curve(traces: list[Trace]) -> GroupCurve:
    return curve_of([trace["reward"] for trace in traces])


def _correct(combinations: list[Combination]) -> tuple[Combination, ...]:
    """The combinations with their p-values corrected for how many they are."""
    corrected: list[dict[str, float | None]] = [{} for _ in combinations]
    for name in CORRECTED:
        raw = [_p(combination, name) for combination in combinations]
        known = [i for i, p in enumerate(raw) if p is not None]
        for i, p in zip(known, holm([p for p in raw if p is not None]), strict=True):
            corrected[i][name] = p
    return tuple(
        replace(combination, corrected={name: values.get(name) for name in CORRECTED})
        for combination, values in zip(combinations, corrected, strict=True)
    )


def _p(combination: Combination, name: str) -> float | None:
    if combination.decomposition is None or combination.baseline == combination.proposed:
        return None  # A/A asks nothing: it must not make the others' corrections stricter
    if name == "success":
        return combination.success.p if combination.success else None
    return combination.splits["eta_N" if name == "eta_n" else "eta_P"].p


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
