"""From cells to outcomes: train what is not trained, validate what is not validated."""

import shutil
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

from harness.errors import Unmeasured
from harness.executor import Executor, OnEvent
from harness.experiment.changed import changed_cells, refuse_changed
from harness.experiment.experiment import ExperimentRun
from harness.experiment.plan import Plan
from harness.experiment.run_options import RunOptions
from harness.experiment.workers.order import Order
from harness.record.cell import Cell
from harness.record.folder import EVALUATION, recording_of
from harness.record.manifest import read_manifest
from harness.record.recording.recorded_training import read_recording
from harness.record.store import Store
from harness.record.trace import read_trace
from harness.registry.choice import build_defaults
from harness.registry.registry import Registry
from harness.results.metrics import named_measures
from harness.tune.outcome import JUDGES, Outcome, outcome_by, outcome_in_environment, outcome_of
from harness.tune.validation import REASON, ValidatePolicy, validate_all

TRIALS, VALIDATION = "trials", "validation"

Follow: TypeAlias = Callable[[Sequence[Cell], Sequence[Cell]], AbstractContextManager[OnEvent]]
"""A function of all cells of a stage and of those that were done before. It returns who is told of their events."""

Outcomes: TypeAlias = Callable[[Plan, Sequence[Cell]], dict[Cell, Outcome | str]]
"""The outcome of each cell of a plan that is asked for, or the reason why it has none."""


@dataclass(frozen=True)
class TrainedOutcomes:
    """Runs cells by the executor and keeps them, as any experiment, in the folder ``trials``; an `Outcomes`.

    Attributes:
        folder: Of the tuning.
        registry: The plugins.
        episodes: Of each validation.
        options: How cells are run.
        executor: What runs them.
        follow: Told what happens.
    """

    folder: Path
    registry: Registry
    episodes: int
    options: RunOptions
    executor: Executor
    follow: Follow

    def __call__(self, plan: Plan, cells: Sequence[Cell]) -> dict[Cell, Outcome | str]:
        """See `Outcomes`."""
        store = Store.create(self.folder / TRIALS, plan)
        self._train(replace(plan, cells=tuple(cells)), store)
        reasons = {cell: read_manifest(store.cell_folder(cell)).reason for cell in cells if not store.is_done(cell)}
        orders = {cell: self._order(cell, store) for cell in cells if cell not in reasons}
        validate_all(list(orders.values()), self.options.at_once)
        named = named_measures(plan.resolved)[:1]
        return {**reasons, **{cell: self._outcome(order, *named) for cell, order in orders.items()}}

    def require_same_plugins(self) -> None:
        """Check that the installed plugins trained what was trained so far.

        Raises:
            UsageError: It was not: the trials could not be compared.
        """
        done = [manifest for manifest in Store(self.folder / TRIALS).manifests() if manifest.status == "done"]
        sources = {manifest.cell: manifest.environment.get("sources", {}) for manifest in done}
        refuse_changed(changed_cells(sources, self.registry), "another --out searches anew")

    def forget_failures(self) -> None:
        """Remove failed and interrupted validations, so that they are done again."""
        folder = self.folder / VALIDATION
        folder.mkdir(exist_ok=True)
        for path in [*(reason.parent for reason in folder.glob(f"*/{REASON}")), *folder.glob(".*.partial")]:
            shutil.rmtree(path)

    def _train(self, plan: Plan, store: Store) -> None:
        options = replace(self.options, changed="keep")  # `require_same_plugins` looked at all trials
        run = ExperimentRun(plan, store, self.registry, self.executor, options)
        with run.begin() as begun, self.follow(plan.cells, begun.done) as on_event:
            begun.run(on_event)

    def _order(self, cell: Cell, store: Store) -> Order:
        work = ValidatePolicy(store.cell_folder(cell), self.episodes, self.registry.given)
        return Order(self.folder / VALIDATION / cell.id, work)

    def _outcome(self, order: Order, named: str = "") -> Outcome | str:
        reason = order.folder / REASON
        if reason.exists():
            return reason.read_text()
        recorded = order.folder / recording_of(EVALUATION)
        try:
            if recorded.is_dir():
                return outcome_in_environment(read_recording(recorded))
            judges = build_defaults(self.registry, "metrics", [named] if named else JUDGES)
            trace = read_trace(order.folder / EVALUATION)
            return outcome_by(named, judges[named], trace) if named else outcome_of(trace, *judges.values())
        except (ValueError, Unmeasured) as error:
            return str(error)
