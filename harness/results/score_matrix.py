"""S[scoring reward][training reward]: every training under every ruler."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from harness.eta.curve import curve_of
from harness.eta.index import Index
from harness.record.cell import Cell
from harness.record.folder import TRACE
from harness.record.trace import Trace, read_trace
from harness.registry.choice import Choice
from harness.registry.registry import Registry
from harness.results.combination import Group
from harness.results.results import Results
from harness.score.scorer import SCORED, score_trace

COLUMNS = [*SCORED, "reward"]


@dataclass(frozen=True)
class ScoreMatrix:
    """The index of each training's runs under each reward, of one simulator, robot, task and algorithm.

    Attributes:
        group: What the runs share.
        seeds: The seeds of each training, by its label.
        indices: By the label of the scoring reward, then that of the training reward.
    """

    group: Group
    seeds: dict[str, tuple[int, ...]]
    indices: dict[str, dict[str, Index]]

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            **self.group.to_json(),
            "seeds": {label: list(seeds) for label, seeds in self.seeds.items()},
            "indices": {
                scoring: {training: index.to_json() for training, index in row.items()}
                for scoring, row in self.indices.items()
            },
        }


def score_matrices(results: Results, scoring: Sequence[Choice], registry: Registry) -> list[ScoreMatrix]:
    """One matrix per group of cells that are done.

    Raises:
        UsageError: A reward is not installed.
    """
    groups: dict[Group, dict[str, list[Cell]]] = {}
    for cell in results.done_cells:
        groups.setdefault(Group.of(cell), {}).setdefault(cell.reward.label, []).append(cell)
    return [_matrix(results, group, trainings, scoring, registry) for group, trainings in groups.items()]


def _matrix(
    results: Results, group: Group, trainings: dict[str, list[Cell]], scoring: Sequence[Choice], registry: Registry
) -> ScoreMatrix:
    traces = {label: [_read(results, cell) for cell in cells] for label, cells in trainings.items()}
    indices = {}
    for choice in scoring:
        reward = choice.build(registry, "rewards")
        indices[choice.label] = {
            label: curve_of([score_trace(reward, trace) for trace in runs]).index for label, runs in traces.items()
        }
    seeds = {label: tuple(sorted(cell.seed for cell in cells)) for label, cells in trainings.items()}
    return ScoreMatrix(group, seeds, indices)


def _read(results: Results, cell: Cell) -> Trace:
    return read_trace(results.store.cell_folder(cell) / TRACE, COLUMNS)
