"""The evaluations of one cell: while it trains, every so many steps, and at the end."""

import time
import traceback
from collections.abc import Callable
from pathlib import Path

from harness.env.make import World
from harness.executor import Word
from harness.experiment.checkpoints.attempt import Attempt
from harness.experiment.evaluation.evaluator import Evaluator
from harness.experiment.evaluation.scalars import named_scalars
from harness.experiment.progress.beat import Beat
from harness.experiment.workers.order import Report
from harness.policy import Policy
from harness.record.cell import Cell
from harness.record.folder import EVALUATION, EVALUATIONS, LOG, RANDOM, evaluation_files, other_manner
from harness.record.returns import mean_return
from harness.record.trace import Trace, read_trace
from harness.registry.registry import Registry


class CellEvaluations:
    """Evaluates policies of a cell in envs of their own, so that the training does not change.

    Attributes:
        seconds: What the evaluations took during training.
    """

    def __init__(
        self, cell: Cell, world: World, registry: Registry, attempt: Attempt, tracked: bool, report: Report
    ) -> None:
        """Go on after the last evaluation that the attempt's checkpoint knows of; later ones are made again.

        Args:
            cell: Whose policies.
            world: The cell's.
            registry: The plugins, for the metrics.
            attempt: Where the training begins.
            tracked: Whether the results are passed on.
            report: Told that an evaluation goes on, and its results.
        """
        self._report, self._steps = report, attempt.begun_from
        self._cell, self._registry, self._tracked = cell, registry, tracked
        beat = Beat(report)
        self._evaluator = Evaluator(world, cell.evaluation_episodes, lambda: beat(self._steps))
        self._folder = attempt.folder
        self.seconds = 0.0
        self._due = cell.evaluate_every
        for steps, path in evaluation_files(self._folder).items():
            if steps > attempt.begun_from:
                path.unlink()
            else:
                self._due = self._next_after(steps)

    def offer(self, steps: int, make: Callable[[], Policy]) -> None:
        """Evaluate what `make` gives if an evaluation is due after `steps`; the one at the end is `finish`'s."""
        if not self._cell.evaluate_every or not self._due <= steps < self._cell.steps:
            return
        clock = time.perf_counter()
        self._steps = steps
        self._due = self._next_after(steps)
        path = self._folder / EVALUATIONS / f"{steps}.parquet"
        path.parent.mkdir(exist_ok=True)
        partial = path.with_name(f".{path.name}")
        self._evaluate(steps, make(), partial)
        partial.rename(path)  # so a killed process leaves no half-written evaluation under this name
        self.seconds += time.perf_counter() - clock

    def finish(self, policy: Policy, floor: bool) -> None:
        """Evaluate the trained policy, as the cell says and in the other manner; for a `floor` random actions too."""
        deterministic = self._cell.deterministic
        self._steps = self._cell.steps
        self._evaluate(self._cell.steps, policy, self._folder / EVALUATION)
        self._evaluator.record(policy, not deterministic, self._folder / other_manner(deterministic))
        if floor:
            self._evaluator.record_random(policy, self._folder / RANDOM)

    def _next_after(self, steps: int) -> int:
        every = self._cell.evaluate_every
        return (steps // every + 1) * every

    def _evaluate(self, steps: int, policy: Policy, path: Path) -> None:
        self._evaluator.record(policy, self._cell.deterministic, path)
        if not self._tracked:
            return
        try:
            scalars = evaluation_scalars(read_trace(path), self._registry)
        except Exception:  # these numbers are only looked at, they change no result
            with (self._folder / LOG).open("a") as log:
                traceback.print_exc(file=log)
        else:
            self._report(Word(steps, scalars))


def evaluation_scalars(trace: Trace, registry: Registry) -> dict[str, float]:
    """The return and all metrics, such as ``Evaluation/Success Rate``. Undefined or failed ones are left out."""
    # Most runs have no tracker: their processes start without what reads results.
    from harness.results.measured import measure
    from harness.results.metrics import load_metrics

    return named_scalars(mean_return(trace), measure(load_metrics(registry), trace))
