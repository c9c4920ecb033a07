"""S[scoring reward][training reward]: every training under every ruler."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from harness.errors import Unscored
from harness.eta.curve import curve_of
from harness.eta.index import Index
from harness.record.cell import Cell
from harness.record.folder import TRACE
from harness.record.trace import Trace, read_trace
from harness.registry.choice import Choice
from harness.registry.registry import Registry
from harness.results.comparison import Group
from harness.results.results import Results
from harness.score.installed_reward import InstalledReward
from harness.score.scorer import SCORED

COLUMNS = [*SCORED, "reward"]


@dataclass(frozen=True)
class ScoreMatrix:
    """The index of each training's runs under each reward, with one simulator, robot, task and algorithm.

    Attributes:
        group: What the runs share.
        seeds: The seeds of each training, by its label.
        indices: By the label of the scoring reward, then that of the training reward.
        failed: Why a reward could not score the runs, by the reward's label.
    """

    group: Group
    seeds: dict[str, tuple[int, ...]]
    indices: dict[str, dict[str, Index]]
    failed: dict[str, str] = field(default_factory=dict)

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            **self.group.to_json(),
            "seeds": {label: list(seeds) for label, seeds in self.seeds.items()},
            "indices": {
                scoring: {training: index.to_json() for training, index in row.items()}
                for scoring, row in self.indices.items()
            },
            "failed": self.failed,
        }


def score_matrices(results: Results, scoring: Sequence[Choice], registry: Registry) -> list[ScoreMatrix]:
    """One matrix per group of cells that are done. A reward that cannot score their runs loses only its own row."""
    groups: dict[Group, dict[str, list[Cell]]] = {}
    for cell in results.done_cells:
        groups.setdefault(Group.of(cell), {}).setdefault(cell.reward.label, []).append(cell)
    return [_matrix(results, group, trainings, scoring, registry) for group, trainings in groups.items()]


def _matrix(
    results: Results, group: Group, trainings: dict[str, list[Cell]], scoring: Sequence[Choice], registry: Registry
) -> ScoreMatrix:
    payers = [InstalledReward(choice, registry) for choice in scoring]
    columns = None if any(map(_reads_more, payers)) else COLUMNS
    traces = {label: [_read(results, cell, columns) for cell in cells] for label, cells in trainings.items()}
    indices: dict[str, dict[str, Index]] = {}
    failed: dict[str, str] = {}
    for payer in payers:
        choice = payer.choice
        try:
            curves = {label: curve_of([payer.pay(run) for run in runs]) for label, runs in traces.items()}
        except Unscored as unscored:
            failed[choice.label] = str(unscored)
        else:
            indices[choice.label] = {label: curve.index for label, curve in curves.items()}
    seeds = {label: tuple(sorted(cell.seed for cell in cells)) for label, cells in trainings.items()}
    return ScoreMatrix(group, seeds, indices, failed)


def _reads_more(payer: InstalledReward) -> bool:
    try:
        return payer.reads_more
    except Unscored:  # its own row will say so
        return False


def _read(results: Results, cell: Cell, columns: list[str] | None) -> Trace:
    return read_trace(results.store.cell_folder(cell) / TRACE, columns)
