"""Run an experiment: from what a user asks for to the results."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from harness.errors import UsageError
from harness.eta.curve import KINDS, Kind
from harness.executor import CellOptions, Event, Executor, Job, OnEvent
from harness.experiment.ended_cells import EndedCells
from harness.experiment.event_log import require_tensorboard
from harness.experiment.plan import Experiment, Plan, check_experiment, expand
from harness.experiment.workers import worker_count
from harness.record.cell import Cell
from harness.record.manifest import read_manifest
from harness.record.out_folder import storage_errors
from harness.record.store import Store
from harness.registry.choice import choose
from harness.registry.registry import Registry, load_registry
from harness.results import Results

DEFAULT_FOLDER = Path("results") / "runs"


@dataclass(frozen=True)
class RunOptions:
    """How an experiment is run; nothing here changes a result.

    Attributes:
        out: The experiment's folder; by default one under ``results/runs/`` named for the plan, so that the same
            experiment goes on where an earlier run stopped.
        jobs: How many cells at once; by default as many as there are cores.
        executor: What runs the cells, with its settings: ``"processes"``, ``"mine:nodes=2"`` or a table.
        checkpoint_every: Environment steps from one checkpoint of a training to the next, at least; 0 for none; by
            default one every ten minutes.
        tensorboard: Whether each cell leaves event files of scalars too, in its folder.
        curve: Which curves the indices are read from afterwards; see `harness.eta.curve.GroupCurve`.
        wait: Whether to wait while another run is using the folder; else that is an error.

    Raises:
        UsageError: A number is out of range, or there is no such curve.
    """

    out: str | Path | None = None
    jobs: int | None = None
    executor: str | Mapping[str, Any] = "processes"
    checkpoint_every: int | None = None
    tensorboard: bool = False
    curve: Kind = "accumulated"
    wait: bool = True

    def __post_init__(self) -> None:
        worker_count(self.jobs)
        if self.checkpoint_every is not None and self.checkpoint_every < 0:
            raise UsageError(f"checkpoint_every={self.checkpoint_every}: must be at least 1, or 0 for none")
        if self.curve not in KINDS:
            raise UsageError(f"curve='{self.curve}': there is {' and '.join(KINDS)}")

    @property
    def at_once(self) -> int:
        """How many cells at once."""
        return worker_count(self.jobs)

    @property
    def of_cells(self) -> CellOptions:
        """What of it each cell is told."""
        return CellOptions(self.checkpoint_every, self.tensorboard)

    def build_executor(self, registry: Registry) -> Executor:
        """What runs the cells.

        Raises:
            UsageError: The executor or a setting of it is not known, or a library for the options is missing.
        """
        if self.tensorboard:
            require_tensorboard()
        executor: Executor = choose(registry, "executors", self.executor).build(registry, "executors")
        return executor


DEFAULTS = RunOptions()


def run(
    *,
    out: str | Path | None = None,
    jobs: int | None = None,
    executor: str | Mapping[str, Any] = "processes",
    checkpoint_every: int | None = None,
    tensorboard: bool = False,
    curve: Kind = "accumulated",
    wait: bool = True,
    **experiment: Any,
) -> Results:
    """Run every combination of an experiment that is not done yet.

    Args:
        out: See `RunOptions`, as the next six.
        jobs: How many cells at once.
        executor: What runs the cells.
        checkpoint_every: Environment steps from one checkpoint of a training to the next.
        tensorboard: Whether each cell leaves event files of scalars too.
        curve: Which curves the indices are read from.
        wait: Whether to wait while another run is using the folder.
        **experiment: The fields of `harness.experiment.plan.Experiment`; the lists may be single names, or text with
            commas.

    Raises:
        UsageError: Something given cannot be used; nothing is written.
    """
    options = RunOptions(out, jobs, executor, checkpoint_every, tensorboard, curve, wait)
    return prepare(check_experiment(experiment), options).run()


@dataclass(frozen=True)
class ExperimentRun:
    """An experiment that is ready to run: everything is checked, and nothing is written but its folder.

    Attributes:
        plan: What to do.
        store: Where.
        registry: The plugins.
        executor: What runs the cells.
        options: How.
    """

    plan: Plan
    store: Store
    registry: Registry
    executor: Executor
    options: RunOptions = DEFAULTS

    def run(self, on_event: OnEvent = lambda event: None) -> Results:
        """Do the cells that are not done yet; see `begin` and `BegunRun.run`."""
        with self.begin() as begun:
            return begun.run(on_event)

    @contextmanager
    def begin(self, on_wait: Callable[[], None] = lambda: None) -> Iterator["BegunRun"]:
        """Keep other runs out of the folder, and write down what is asked for.

        Args:
            on_wait: Called before this waits for another run in the folder to end, if the options say to wait.

        Raises:
            UsageError: Another run is using the folder, and the options say not to wait. Nothing is written.
            StorageError: The folder cannot be written, now or while the cells run.
        """
        with storage_errors(self.store.folder), self.store.locked(on_wait if self.options.wait else None):
            self.store.add(self.plan)
            yield BegunRun(self, tuple(cell for cell in self.plan.cells if self.store.is_done(cell)))


@dataclass(frozen=True)
class BegunRun:
    """An experiment that has its folder for itself.

    Attributes:
        asked: What is to be run.
        done: Cells that were done before, and are not run again.
    """

    asked: ExperimentRun
    done: tuple[Cell, ...]

    def run(self, on_event: OnEvent = lambda event: None) -> Results:
        """Do the cells that are not done yet.

        Args:
            on_event: Told what happens to the cells.

        Returns:
            What the experiment's folder says afterwards, earlier cells included.
        """
        store, options, done = self.asked.store, self.asked.options, set(self.done)
        waiting = [cell for cell in self.asked.plan.cells if cell not in done]
        # What else was begun stays too: run_cell says what becomes of it.
        store.discard_partial(keep={store.reopen(cell) for cell in waiting})
        ended = EndedCells(store, self.asked.registry, self.asked.plan)
        jobs = [Job(cell, store.cell_folder(cell), options.of_cells) for cell in waiting]
        try:
            self.asked.executor.run(jobs, options.at_once, lambda event: on_event(self._recorded(event, ended)))
        finally:
            store.discard_partial()
        return Results(store.folder, self.asked.registry, options.curve)

    def _recorded(self, event: Event, ended: EndedCells) -> Event:
        """The event with what the cell's manifest says; leaves a manifest for a cell that could not leave one."""
        store = self.asked.store
        if event.kind != "ended":
            return event
        if event.reason:
            store.record(event.cell, "failed", event.reason)
        manifest = read_manifest(store.cell_folder(event.cell))
        if manifest.status == "done":
            ended.keep(manifest)
        return event._replace(reason=manifest.reason, note=manifest.note)


def prepare(experiment: Experiment, options: RunOptions = DEFAULTS) -> ExperimentRun:
    """Check everything that an experiment needs, then make its folder, or look whether it can go on with one.

    Raises:
        UsageError: Something given cannot be used; nothing is written.
    """
    registry = load_registry()
    executor = options.build_executor(registry)
    plan = expand(experiment, registry)
    store = Store.claim(Path(options.out) if options.out else default_folder(plan))
    return ExperimentRun(plan, store, registry, executor, options)


def default_folder(plan: Plan) -> Path:
    """A folder named for what the plan does: the same plan finds its results again."""
    first = plan.cells[0] if plan.cells else plan.skipped[0][0]
    return DEFAULT_FOLDER / f"{first.simulator.name}-{first.algorithm.name}-{plan.id}"
