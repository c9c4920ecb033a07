"""Train and evaluate one cell: the only place that does. It needs the cell and a folder, nothing else."""

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from harness.algorithm import Algorithm
from harness.executor import CellOptions, Word
from harness.experiment.cell_progress import CellEvaluations, CellProgress
from harness.experiment.checkpoints.checkpoint import Attempt, begin_attempt
from harness.experiment.checkpoints.stored_rings import discard_rings
from harness.experiment.checkpoints.trace_parts import discard_parts
from harness.experiment.draft import Draft, draft_of
from harness.experiment.watch import UNWATCHED, Watch
from harness.experiment.workers.order import Report
from harness.experiment.world import CellWorld, world_of
from harness.files.plain import Plain
from harness.policy import Policy
from harness.record.cell import Cell
from harness.record.folder import CHECKPOINT, POLICY, TRACE
from harness.record.manifest import Manifest
from harness.registry.registry import Registry, load_registry

DEFAULTS = CellOptions()


def run_cell(
    cell: Cell, folder: Path, report: Report, options: CellOptions = DEFAULTS, watch: Watch = UNWATCHED
) -> Manifest:
    """Do `cell` and leave its trace, policy, evaluation and manifest in `folder`.

    The folder is written beside its final name and renamed when complete. What a plugin raises ends up in the
    manifest, as the reason of a failed cell, and in the log. If this process is killed, the next call goes on from the
    last checkpoint, if it left one.

    Args:
        cell: What to do.
        folder: Of the cell; replaced if it exists.
        report: Told how far it is.
        options: How to do it.
        watch: Looks on.
    """
    with draft_of(folder, Manifest(cell, status="done")) as draft:
        forget_peak()
        try:
            _Run(cell, load_registry(given=options.plugins), report, options, watch).leave(draft)
        finally:
            draft.note(peak_memory=peak_memory())
            (draft.partial / CHECKPOINT).unlink(missing_ok=True)
            discard_rings(draft.partial)
            discard_parts(draft.partial / TRACE)
    return draft.record


@dataclass(frozen=True)
class TrainCell(Plain):
    """`run_cell`, as a worker is told to do it."""

    cell: Cell
    options: CellOptions = DEFAULTS

    noun: ClassVar[str] = "cell"

    def do(self, folder: Path, report: Report) -> bool:
        return run_cell(self.cell, folder, report, self.options).status == "done"


@dataclass(frozen=True)
class _Run:
    """The run of one cell: what all its steps need."""

    cell: Cell
    registry: Registry
    report: Report
    options: CellOptions
    watch: Watch

    def leave(self, draft: Draft[Manifest]) -> None:
        """Train and evaluate; leave everything but the manifest, and put into that what there is to say."""
        cell, registry = self.cell, self.registry
        world = world_of(cell, registry, draft.partial, self.report, self.watch)
        draft.note(environment=dict(world.runs_on))
        algorithm: Algorithm = cell.algorithm.build(registry, "algorithms")
        draft.note(**world.build(algorithm))
        attempt = begin_attempt(cell, draft.partial, world.runs_on, self.options.checkpoint_every, world.restore)
        draft.note(resumed_from=attempt.begun_from, note=attempt.note)
        self.report(Word(attempt.begun_from))
        evaluations = CellEvaluations(cell, world, attempt, self.options.tracked, self.report)
        policy = self._train(algorithm, world, attempt, evaluations)
        draft.note(training_seconds=round(attempt.seconds - evaluations.seconds, 3))
        policy.save(draft.partial / POLICY, cell.to_json())
        self.watch.enter("evaluation")
        evaluations.finish(policy, self.options.floor)
        draft.note(note="; ".join(filter(None, (attempt.note, *world.finish(draft.partial)))))
        self.watch.enter("saving")

    def _train(self, algorithm: Algorithm, world: CellWorld, attempt: Attempt, evaluations: CellEvaluations) -> Policy:
        """Train in the world, which stands where the attempt begins."""
        cell = self.cell
        env_seed, algorithm_seed = (int(seed) for seed in np.random.SeedSequence(cell.seed).generate_state(2))
        with world.training(attempt) as env:
            if attempt.checkpoint is None:
                env.reset(seed=env_seed)
            progress = CellProgress(self.report, attempt, world, evaluations, self.options.tracked)
            policy = algorithm.train(env, cell.steps, algorithm_seed, progress)
            steps = min(env.environment_steps, cell.steps)
            self.report(Word(steps, world.learned(steps)))
        return policy


FORGET, STATUS = Path("/proc/self/clear_refs"), Path("/proc/self/status")
PEAK = "VmHWM:"


def forget_peak() -> None:
    """Forget the peak so far. Only Linux can do that; elsewhere the peak stays that of the whole process."""
    try:
        FORGET.write_text("5")
    except OSError:
        return  # no Linux, or one that allows it to nobody


def peak_memory() -> int:
    """The peak in bytes; 0 if the system does not tell it, as on Windows."""
    try:
        lines = STATUS.read_text().splitlines()
        return 1024 * int(next(line.split()[1] for line in lines if line.startswith(PEAK)))
    except (OSError, StopIteration):
        return _peak_of_process()


def _peak_of_process() -> int:
    if sys.platform == "win32":
        return 0
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak
