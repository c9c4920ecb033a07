"""S[scoring reward][training reward]: every training under every ruler."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import pyarrow.parquet as pq

from harness.arrays import Float
from harness.eta.curve import curve_of
from harness.eta.index import Index
from harness.files.bounded import reading
from harness.files.plain import Plain, tells
from harness.record.cell import Cell
from harness.record.cell_log import cell_log
from harness.record.folder import SCORES, TRACE
from harness.registry.choice import Choice, Registry
from harness.results.comparison import Group
from harness.results.results import Results
from harness.score.rescore import rescore


@tells("*group", "seeds", "indices", "failed")
@dataclass(frozen=True)
class ScoreMatrix(Plain):
    """The index of each training's runs under each reward, with one simulator, robot, task and algorithm.

    Attributes:
        group: What the runs share.
        seeds: The seeds of each training, by its label.
        indices: By the label of the scoring reward, then that of the training reward; without those that could not be
            scored.
        failed: Why a reward could not score all runs, by the reward's label.
    """

    group: Group
    seeds: dict[str, tuple[int, ...]]
    indices: dict[str, dict[str, Index]]
    failed: dict[str, str] = field(default_factory=dict)


def score_matrices(results: Results, scoring: Sequence[Choice], registry: Registry) -> list[ScoreMatrix]:
    """Pay every done cell by every reward, into a file beside its trace; one matrix per group of cells.

    A reward that cannot score a training leaves out that entry alone.

    Raises:
        UsageError: A file cannot be written.
        SchemaError: A file is damaged or written by a newer version.
    """
    groups: dict[Group, dict[str, list[Cell]]] = {}
    for cell in results.done_cells:
        groups.setdefault(Group.of(cell), {}).setdefault(cell.reward.label, []).append(cell)
    return [_matrix(results, group, trainings, scoring, registry) for group, trainings in groups.items()]


def _matrix(
    results: Results, group: Group, trainings: dict[str, list[Cell]], scoring: Sequence[Choice], registry: Registry
) -> ScoreMatrix:
    indices: dict[str, dict[str, Index]] = {choice.label: {} for choice in scoring}
    failed: dict[str, str] = {}
    for training, cells in trainings.items():
        places = [results.store.cell_folder(cell) for cell in cells]
        refused = [rescore(cell_log(it / TRACE), scoring, it / SCORES, registry) for it in places]
        for label, row in indices.items():
            if reasons := [told[label] for told in refused if label in told]:
                is_own = training.partition(":")[0] == label.partition(":")[0]  # its own terms say most
                failed[label] = reasons[0] if is_own else failed.get(label, reasons[0])
                continue
            runs = list[Float]()
            for scores in [it / SCORES for it in places]:
                with reading(scores, "file of scores"):
                    runs.append(np.asarray(pq.read_table(scores, columns=[label]).column(label).to_numpy()))
            row[training] = curve_of(runs).index
    seeds = {label: tuple(sorted(cell.seed for cell in cells)) for label, cells in trainings.items()}
    return ScoreMatrix(group, seeds, {label: row for label, row in indices.items() if row}, failed)
