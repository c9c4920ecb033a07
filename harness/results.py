"""What an experiment's folder says: combinations compared, cells, behaviour. Reads results only."""

from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from harness.cell import Cell
from harness.cell_folder import EVALUATION, RANDOM, TRACE
from harness.choice import Choice
from harness.index import Index, Ratio, stack_runs
from harness.manifest import Manifest
from harness.metric import Metric
from harness.plugins import Registry, load_registry
from harness.statistics import compare_runs
from harness.store import RESULTS, Store
from harness.trace import read_trace

Float = NDArray[np.float64]
Values = dict[str, float | None]


class Group(NamedTuple):
    """What the cells of one combination share, their rewards and seeds apart."""

    simulator: Choice
    robot: str
    task: Choice
    algorithm: Choice
    steps: int
    evaluation_episodes: int


@dataclass(frozen=True)
class Behaviour:
    """One metric of a combination's evaluation, means over seeds; no reward enters it."""

    name: str
    unit: str
    better: str
    baseline: float | None
    proposed: float | None
    random: float | None


@dataclass(frozen=True, eq=False)
class Combination:
    """One proposed reward against the baseline, on one simulator, robot, task and algorithm.

    Attributes:
        group: What both share.
        baseline: Label of the baseline reward.
        proposed: Label of the proposed reward.
        seeds: Those that are done under both rewards, and compared.
        eta_n: NOTE eq. 43.
        eta_p: NOTE eq. 44.
        baseline_index: None without a seed.
        proposed_index: None without a seed.
        behaviour: Of the trained policies and of random actions, by metric.
        baseline_runs: Accumulated reward of each run, (seeds, rows).
        proposed_runs: The same.
    """

    group: Group
    baseline: str
    proposed: str
    seeds: tuple[int, ...]
    eta_n: Ratio
    eta_p: Ratio
    baseline_index: Index | None
    proposed_index: Index | None
    behaviour: tuple[Behaviour, ...]
    baseline_runs: Float
    proposed_runs: Float

    def to_json(self) -> dict[str, Any]:
        """Plain data, the runs left out."""
        success = next((metric for metric in self.behaviour if metric.name == "success_rate"), None)
        return {
            "simulator": self.group.simulator.label,
            "algorithm": self.group.algorithm.label,
            "robot": self.group.robot,
            "task": self.group.task.label,
            "steps": self.group.steps,
            "baseline": self.baseline,
            "proposed": self.proposed,
            "seeds": list(self.seeds),
            "eta_n": asdict(self.eta_n),
            "eta_p": asdict(self.eta_p),
            "baseline_index": self.baseline_index and asdict(self.baseline_index),
            "proposed_index": self.proposed_index and asdict(self.proposed_index),
            "success": {who: success and getattr(success, who) for who in ("baseline", "proposed", "random")},
            "behaviour": [asdict(metric) for metric in self.behaviour],
        }


class Results:
    """An experiment as its folder tells it."""

    def __init__(self, folder: Path, registry: Registry) -> None:
        self.folder = folder
        self.store = Store.open(folder)
        self._registry = registry
        self.baseline, planned = self.store.read_plan()
        ended = {manifest.cell.id: manifest for manifest in self.store.manifests()}
        self.manifests = [ended.get(cell.id) or Manifest(cell, "pending", "not run yet") for cell in planned]

    @cached_property
    def metrics(self) -> dict[str, Metric]:
        """Every registered metric, by name."""
        names = self._registry.names("metrics")
        return {name: self._registry.get("metrics", name).load()() for name in names}

    @cached_property
    def evaluations(self) -> dict[str, Values]:
        """By cell id: every metric of the trained policy, and with ``random_`` before it of random actions."""
        return {manifest.cell.id: self._evaluate(manifest.cell) for manifest in self._done}

    @cached_property
    def combinations(self) -> tuple[Combination, ...]:
        """Every proposed reward against the baseline."""
        proposed = dict.fromkeys(
            (_group(manifest.cell), manifest.cell.reward)
            for manifest in self.manifests
            if manifest.cell.reward.label != self.baseline and manifest.status != "skipped"
        )
        return tuple(self._combine(group, reward) for group, reward in proposed)

    @property
    def failed(self) -> list[Manifest]:
        """Cells that failed."""
        return [manifest for manifest in self.manifests if manifest.status == "failed"]

    def to_json(self) -> dict[str, Any]:
        """What ``harness report --json`` prints."""
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
        pq.write_table(table, path)
        return path

    @property
    def _done(self) -> list[Manifest]:
        return [manifest for manifest in self.manifests if manifest.status == "done"]

    def _evaluate(self, cell: Cell) -> Values:
        folder = self.store.cell_folder(cell)
        values: Values = {}
        for prefix, file in (("", EVALUATION), ("random_", RANDOM)):
            trace = read_trace(folder / file)
            values.update({prefix + name: metric(trace) for name, metric in self.metrics.items()})
        return values

    def _combine(self, group: Group, proposed: Choice) -> Combination:
        members = [manifest.cell for manifest in self._done if _group(manifest.cell) == group]
        by_seed_b = {cell.seed: cell for cell in members if cell.reward.label == self.baseline}
        by_seed_k = {cell.seed: cell for cell in members if cell.reward == proposed}
        seeds = tuple(sorted(by_seed_b.keys() & by_seed_k.keys()))
        if not seeds:
            empty = f"no seed is done under both {self.baseline} and {proposed.label}"
            nothing, none = Ratio(None, note=empty), np.empty((0, 0))
            return Combination(group, self.baseline, proposed.label, (), nothing, nothing, None, None, (), none, none)
        cells_b, cells_k = [by_seed_b[seed] for seed in seeds], [by_seed_k[seed] for seed in seeds]
        runs_b, runs_k = self._read_runs(cells_b), self._read_runs(cells_k)
        compared = compare_runs(runs_b, runs_k)
        return Combination(
            group,
            self.baseline,
            proposed.label,
            seeds,
            compared.eta_n,
            compared.eta_p,
            compared.baseline,
            compared.proposed,
            tuple(self._compare_behaviour(name, metric, cells_b, cells_k) for name, metric in self.metrics.items()),
            runs_b,
            runs_k,
        )

    def _read_runs(self, cells: list[Cell]) -> Float:
        return stack_runs([read_trace(self.store.cell_folder(cell) / TRACE, ["reward"])["reward"] for cell in cells])

    def _compare_behaviour(self, name: str, metric: Metric, baseline: list[Cell], proposed: list[Cell]) -> Behaviour:
        def mean(cells: list[Cell], column: str) -> float | None:
            values = [value for cell in cells if (value := self.evaluations[cell.id][column]) is not None]
            return float(np.mean(values)) if values else None

        return Behaviour(
            name,
            metric.unit,
            metric.better,
            mean(baseline, name),
            mean(proposed, name),
            mean([*baseline, *proposed], f"random_{name}"),
        )


def load_results(folder: str | Path) -> Results:
    """The results in an experiment's folder.

    Raises:
        UsageError: The folder is no experiment's.
        SchemaError: A file in it is damaged or written by a newer version.
    """
    return Results(Path(folder), load_registry())


def _group(cell: Cell) -> Group:
    return Group(cell.simulator, cell.robot, cell.task, cell.algorithm, cell.steps, cell.evaluation_episodes)


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
