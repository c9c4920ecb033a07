"""From cells to outcomes: train what is not trained, validate what is not validated.

Validation: episodes that policies of a search are judged by. Their starts and targets are drawn from another seed than
those of the evaluation after a training (`harness.experiment.arm_evaluation`). So no comparison that follows uses
the episodes that chose the settings.
"""

import shutil
import traceback
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar, Self, TypeAlias

from harness.authoring.commands import (
    EVALUATION,
    POLICY,
    UNWATCHED,
    Cell,
    ExperimentRun,
    Given,
    News,
    Order,
    Plan,
    Registry,
    Report,
    RunOptions,
    Store,
    build_defaults,
    changed_cells,
    given_from_json,
    given_to_json,
    load_registry,
    named_measures,
    partial_folder,
    publish,
    read_manifest,
    read_recording,
    read_trace,
    recording_of,
    refuse_changed,
    run_orders,
    world_of,
)
from harness.errors import Unmeasured, one_line
from harness.executor import Executor, OnEvent
from harness.policy import Policy, load_policy

from .trial import JUDGES, Outcome, outcome_by, outcome_in_environment, outcome_of

VALIDATION_SEED = 20_230_705
"""Seed of the starts and targets of every validation. It is not the evaluation's, and not a small number."""
REASON = "reason.txt"
"""The file in the folder of a failed validation that says why there is no trace."""
TRIALS, VALIDATION = "trials", "validation"

Follow: TypeAlias = Callable[[Sequence[Cell], Sequence[Cell]], AbstractContextManager[OnEvent]]
"""A function of all cells of a stage and of those that were done before. It returns who is told of their events."""

Outcomes: TypeAlias = Callable[[Plan, Sequence[Cell]], dict[Cell, Outcome | str]]
"""The outcome of each cell of a plan that is asked for, or the reason why it has none."""


@dataclass(frozen=True)
class ValidatePolicy:
    """One policy to validate, as a worker is told to do it.

    It leaves a folder with the recording of these episodes, or with the `REASON` why there is none.

    Attributes:
        cell_folder: Of the done cell that trained it.
        episodes: How many.
        plugins: Given by hand.
    """

    cell_folder: Path
    episodes: int
    plugins: tuple[Given, ...] = ()

    noun: ClassVar[str] = "validation"

    def to_json(self) -> dict[str, Any]:
        told = {"cell_folder": str(self.cell_folder), "episodes": self.episodes}
        return {**told, "plugins": given_to_json(self.plugins)}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        return cls(Path(data["cell_folder"]), data["episodes"], given_from_json(data["plugins"]))

    def do(self, folder: Path, report: Report) -> bool:
        """See `harness.experiment.workers.order.Work`; a plugin may raise anything."""
        partial = partial_folder(folder)
        partial.mkdir(parents=True, exist_ok=True)
        try:
            cell, policy = read_manifest(self.cell_folder).cell, load_policy(self.cell_folder / POLICY)
            registry = load_registry(given=self.plugins)
            record_validation(cell, registry, policy, self.episodes, partial, report)
        except (Exception, SystemExit) as error:
            traceback.print_exc()
            _leave_reason(folder, one_line(error))
            return False
        publish(partial, folder)
        return True


def validate_all(orders: Sequence[Order], at_once: int) -> None:
    """Have policies validated, in processes of their own: an engine that crashes costs one policy alone.

    Args:
        orders: Each a `ValidatePolicy`. Those whose folder is there are not done again; each of the others then has its
            folder.
        at_once: How many processes.
    """

    def hear(news: News) -> None:
        if news.kind == "ended" and news.reason:
            _leave_reason(news.folder, news.reason)

    run_orders([order for order in orders if not order.folder.exists()], at_once, hear)


def record_validation(
    cell: Cell, registry: Registry, policy: Policy, episodes: int, folder: Path, report: Report
) -> None:
    """Let `policy` do `episodes` episodes where the cell was trained, and record them in `folder`."""
    world = world_of(cell, registry, folder, report, UNWATCHED)
    path = folder / f"{recording_of(EVALUATION)}{world.suffix}"
    world.evaluate(policy, "deterministic", episodes, path, seed=VALIDATION_SEED)


def _leave_reason(folder: Path, reason: str) -> None:
    partial = partial_folder(folder)
    (partial / EVALUATION).unlink(missing_ok=True)
    shutil.rmtree(partial / recording_of(EVALUATION), ignore_errors=True)
    (partial / REASON).write_text(reason)
    publish(partial, folder)


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
