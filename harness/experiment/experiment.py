"""Run an experiment: from the plan to the results."""

from pathlib import Path
from typing import Any

from harness.errors import UsageError
from harness.executor import Event, Executor, Job, OnEvent
from harness.experiment.event_log import require_tensorboard
from harness.experiment.plan import Plan, check_experiment, expand
from harness.experiment.workers import core_count
from harness.record.manifest import read_manifest
from harness.record.store import Store
from harness.registry.registry import Registry, load_registry
from harness.results import Results

DEFAULT_FOLDER = Path("results") / "runs"


def run(
    *,
    out: str | Path | None = None,
    jobs: int | None = None,
    checkpoint_every: int = 0,
    tensorboard: bool = False,
    **experiment: Any,
) -> Results:
    """Run every combination of an experiment that is not done yet.

    Args:
        out: The experiment's folder; by default one under ``results/runs/`` named for the plan, so that the same call
            goes on where an earlier one stopped.
        jobs: How many cells at once; by default as many as there are cores.
        checkpoint_every: Environment steps from one checkpoint of a training to the next, at least; 0 for none.
        tensorboard: Whether each cell leaves event files of scalars too, in its folder.
        **experiment: The fields of `harness.experiment.plan.Experiment`; the lists may be single names, or text with
            commas.

    Raises:
        UsageError: Something given cannot be used; nothing is written.
    """
    if jobs is not None and jobs < 1:
        raise UsageError(f"jobs={jobs}: must be at least 1")
    if checkpoint_every < 0:
        raise UsageError(f"checkpoint_every={checkpoint_every}: must be at least 1, or 0 for none")
    if tensorboard:
        require_tensorboard()
    registry = load_registry()
    plan = expand(check_experiment(experiment), registry)
    store = Store.create(Path(out) if out else default_folder(plan), plan)
    run_plan(plan, store, registry, jobs or core_count(), checkpoint_every=checkpoint_every, tensorboard=tensorboard)
    return Results(store.folder, registry)


def default_folder(plan: Plan) -> Path:
    """A folder named for what the plan does: the same plan finds its results again."""
    first = plan.cells[0] if plan.cells else plan.skipped[0][0]
    return DEFAULT_FOLDER / f"{first.simulator.name}-{first.algorithm.name}-{plan.id}"


def run_plan(
    plan: Plan,
    store: Store,
    registry: Registry,
    jobs: int,
    on_event: OnEvent = lambda event: None,
    executor: str = "processes",
    checkpoint_every: int = 0,
    tensorboard: bool = False,
) -> None:
    """Do the cells of a plan that are not done yet.

    Args:
        plan: What to do.
        store: Where.
        registry: The plugins.
        jobs: How many cells at once.
        on_event: Told what happens to the cells.
        executor: Registered name of what runs them.
        checkpoint_every: Environment steps from one checkpoint of a training to the next, at least; 0 for none.
        tensorboard: Whether each cell leaves event files of scalars too.
    """
    runner: Executor = registry.get("executors", executor).load()()
    with store.locked():
        waiting = [cell for cell in plan.cells if not store.is_done(cell)]
        # What else was begun stays too: run_cell says what becomes of it.
        store.discard_partial(keep={store.reopen(cell) for cell in waiting})
        jobs_to_do = [Job(cell, store.cell_folder(cell), checkpoint_every, tensorboard) for cell in waiting]

        def record(event: Event) -> None:
            if event.kind == "ended":
                if event.reason:
                    store.record(event.cell, "failed", event.reason)
                manifest = read_manifest(store.cell_folder(event.cell))
                event = event._replace(reason=manifest.reason, note=manifest.note)
            on_event(event)

        try:
            runner.run(jobs_to_do, jobs, record)
        finally:
            store.discard_partial()
