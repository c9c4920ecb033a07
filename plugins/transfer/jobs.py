"""Policies trained in one simulator, evaluated in others: what there is to do, and getting it done."""

import os
import shutil
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar, Literal, NamedTuple, TypeAlias

from harness import load_results, load_robot
from harness.env.vector_env import build_world
from harness.errors import HarnessError, UsageError
from harness.experiment.arm_evaluation import record_evaluation
from harness.experiment.provenance import describe_environment
from harness.experiment.run_cell import draft_of, leave_record
from harness.experiment.workers.order import Order, Report
from harness.experiment.workers.workers import News, run_orders, worker_count
from harness.policy import load_policy
from harness.record import EVALUATION, POLICY, Cell, Store, read_manifest
from harness.record.cell import now
from harness.record.out_folder import storage_errors
from harness.registry import (
    Choice,
    Registry,
    choose,
    load_registry,
    read_given,
    split_list,
)
from harness.registry.given import Given
from harness.registry.spec import PLANNED
from harness.results import Results
from harness.simulator import require_drives
from harness.text import command_text

from .matrix import Transfers, load_transfers
from .record import TRANSFER, TransferRecord, policy_digest, read_transfer, simulator_id

KINDS = ("simulators", "tasks", "rewards")
"""What makes the result; the library that trained the policy is not needed, and need not be there."""


def evaluate_elsewhere(
    cell_folder: Path, simulator: Choice, folder: Path, plugins: Sequence[Given] = ()
) -> TransferRecord:
    """Let the policy of a done cell do the cell's evaluation episodes in `simulator`.

    The folder is written beside its final name and renamed when complete. What a plugin raises ends up in the record,
    as the reason of a failed evaluation, and in the log.

    Args:
        cell_folder: Of the cell that trained the policy.
        simulator: Where to evaluate it.
        folder: To leave; replaced if it exists.
        plugins: Given by hand.
    """
    trained = read_manifest(cell_folder).cell
    record = TransferRecord(trained.id, simulator, policy_digest(cell_folder), status="done")
    with draft_of(folder, record) as draft:
        registry, cell = load_registry(given=plugins), replace(trained, simulator=simulator)
        robot = load_robot(cell.robot, registry)
        draft.note(environment=describe_environment(cell, robot, registry, KINDS))
        world, policy = build_world(cell, robot, registry), load_policy(cell_folder / POLICY)
        record_evaluation(world, policy, cell.acted, cell.evaluation_episodes, draft.partial / EVALUATION)
    return draft.record


@dataclass(frozen=True)
class EvaluateElsewhere:
    """`evaluate_elsewhere`, as a worker is told to do it.

    Attributes:
        cell_folder: Of the cell that trained the policy.
        simulator: Where to evaluate it.
        plugins: Given by hand.
    """

    cell_folder: Path
    simulator: Choice
    plugins: tuple[Given, ...] = ()

    noun: ClassVar[str] = "evaluation"

    def do(self, folder: Path, report: Report) -> bool:
        return evaluate_elsewhere(self.cell_folder, self.simulator, folder, self.plugins).status == "done"


@dataclass(frozen=True)
class TransferJob:
    """One cell's policy and the simulator to evaluate it in.

    Attributes:
        cell: That trained the policy.
        simulator: Another than the cell's.
        folder: To leave.
    """

    cell: Cell
    simulator: Choice
    folder: Path

    @property
    def title(self) -> str:
        return f"{self.cell.title} in {self.simulator.label}"


class TransferEvent(NamedTuple):
    """Something that happened to a job."""

    kind: Literal["started", "ended"]
    job: TransferJob
    reason: str = ""
    """The reason why an ended job failed; empty if it did not."""


@dataclass(frozen=True)
class TransferPlan:
    """What an experiment's policies have to be evaluated in.

    Attributes:
        store: The experiment's folder.
        jobs: Every policy in every simulator but its own.
        missing: Those of the jobs that are not done yet.
        left_out: A line for each simulator that cannot be used here and was not asked for.
        plugins: Given by hand: the evaluations need them too.
    """

    store: Store
    jobs: tuple[TransferJob, ...]
    missing: tuple[TransferJob, ...]
    left_out: tuple[str, ...]
    plugins: tuple[Given, ...] = ()


Named: TypeAlias = str | dict[str, Any]
"""A simulator with parameters, as text or as a table."""
OnEvent: TypeAlias = Callable[[TransferEvent], None]


def transfer(
    folder: str | Path,
    to: str | Sequence[Named] | None = None,
    jobs: int | None = None,
    plugins: Iterable[str | Path | type] = (),
) -> Transfers:
    """Evaluate an experiment's policies in other simulators; what was evaluated before is not again.

    Args:
        folder: The experiment's.
        to: Simulators to evaluate in, ``"mujoco:substeps=40,kinematic"``; by default those of the experiment and all
            that are installed.
        jobs: How many evaluations at once; by default as many as there are cores.
        plugins: Files and classes beside the installed plugins.

    Returns:
        Every transfer that the folder records, those of earlier calls included.

    Raises:
        UsageError: Something given cannot be used; nothing is written.
    """
    at_once = worker_count(jobs)
    registry = load_registry(given=read_given(plugins))
    results = load_results(folder, registry=registry)
    run_transfers(plan_transfers(results, to, registry), at_once)
    return load_transfers(results)


def plan_transfers(results: Results, to: str | Sequence[Named] | None, registry: Registry) -> TransferPlan:
    """What there is to do. Writes nothing.

    Raises:
        UsageError: No cell is done, a simulator is not known or not installed, or a cell's task, reward or robot is
            gone.
    """
    cells = results.done_cells
    if any("simulators" not in it.cell.plugins for it in results.manifests):
        raise UsageError(
            f"harness transfer needs traces of an arm, and the cells of '{results.folder}' are recorded trainings in "
            f"an environment: {command_text('harness', 'report', results.folder)} compares them"
        )
    if not cells:
        raise UsageError(f"'{results.folder}' has no finished cell: nothing is trained that could be evaluated")
    simulators, left_out = _choose(to, registry) if to is not None else _choose_all(cells, registry)
    jobs = tuple(
        TransferJob(cell, simulator, results.store.folder / TRANSFER / cell.id / simulator_id(simulator))
        for cell in cells
        for simulator in simulators
        if simulator != cell.simulator
    )
    missing = tuple(job for job in jobs if not _is_done(job, results.store))
    _require_plugins(missing, results.folder, registry)
    return TransferPlan(results.store, jobs, missing, left_out, registry.given)


def run_transfers(plan: TransferPlan, at_once: int, on_event: OnEvent = lambda event: None) -> None:
    """Do what a plan misses, each evaluation in a process of its own.

    Args:
        plan: What to do.
        at_once: How many evaluations.
        on_event: Called in this thread, when one starts and when it has ended.

    Raises:
        UsageError: The folder cannot be written, or another run is using it.
        StorageError: The disk is full or fails.
    """
    if not plan.missing:
        return
    if not os.access(plan.store.folder, os.W_OK | os.X_OK):
        raise UsageError(f"'{plan.store.folder}' allows no writing here: copy the experiment to where you may write")
    by_folder = {job.folder: job for job in plan.missing}

    def tell(news: News) -> None:
        job = by_folder[news.folder]
        if news.kind == "started":
            on_event(TransferEvent("started", job))
        elif news.kind == "ended":
            on_event(TransferEvent("ended", job, _reason(job, news, plan.store)))

    with storage_errors(plan.store.folder), plan.store.locked():
        _discard_partial(plan.store)
        try:
            run_orders(
                [
                    Order(job.folder, EvaluateElsewhere(plan.store.cell_folder(job.cell), job.simulator, plan.plugins))
                    for job in plan.missing
                ],
                at_once,
                tell,
            )
        finally:
            _discard_partial(plan.store)


def _choose(to: str | Sequence[Named], registry: Registry) -> tuple[list[Choice], tuple[str, ...]]:
    """The simulators that were asked for, each once."""
    given = (
        split_list(to)
        if isinstance(to, str)
        else [name for item in to for name in (split_list(item) if isinstance(item, str) else [item])]
    )
    return list(dict.fromkeys(choose(registry, "simulators", item) for item in given)), ()


def _choose_all(cells: Iterable[Cell], registry: Registry) -> tuple[list[Choice], tuple[str, ...]]:
    """The experiment's simulators and all that are registered, as far as they can be used here."""
    chosen: dict[Choice, None] = {}
    left_out: dict[str, None] = {}
    for simulator in dict.fromkeys(cell.simulator for cell in cells):
        try:
            simulator.build(registry, "simulators")
            chosen[simulator] = None
        except HarnessError as error:
            left_out[f"{simulator.label} is left out: {error}"] = None
    for name in registry.names("simulators"):
        try:
            chosen[choose(registry, "simulators", name)] = None
        except HarnessError as error:
            left_out[f"{name} is left out: {error}"] = None
    return list(chosen), tuple(left_out)


def _is_done(job: TransferJob, store: Store) -> bool:
    record = read_transfer(job.folder)
    if record is None or record.status != "done":
        return False
    return record.is_of(policy_digest(store.cell_folder(job.cell)))


def _require_plugins(jobs: Sequence[TransferJob], folder: Path, registry: Registry) -> None:
    """Raises UsageError where something of the cells is not here any more, or a robot lacks what a simulator needs."""
    wanted = ((job.cell.robot, job.cell.task, job.cell.reward, job.simulator) for job in jobs)
    for robot, task, reward, simulator in dict.fromkeys(wanted):
        try:
            built, arm = task.build(registry, "tasks"), load_robot(robot, registry)
            with task.blamed(registry, "tasks", PLANNED):
                built.check(arm)
            reward.build(registry, "rewards")
            require_drives(simulator.build(registry, "simulators"), arm)
        except UsageError as error:
            raise UsageError(f"Cells of '{folder}' cannot be evaluated: {error}") from None


def _reason(job: TransferJob, news: News, store: Store) -> str:
    """Why an ended job failed; leaves a record for one that could not leave it itself."""
    if news.reason:
        digest = policy_digest(store.cell_folder(job.cell))
        record = TransferRecord(job.cell.id, job.simulator, digest, status="failed", reason=news.reason, started=now())
        leave_record(job.folder, record)
        return news.reason
    left = read_transfer(job.folder)
    return left.reason if left else "it left no record"


def _discard_partial(store: Store) -> None:
    """Remove what a killed call left."""
    for folder in (store.folder / TRANSFER).glob("*/.*.partial"):
        shutil.rmtree(folder)
