"""Run an experiment: from the plan to the results."""

import os
from pathlib import Path
from typing import Any

from harness.errors import UsageError
from harness.executor import Event, Executor, Job, OnEvent
from harness.manifest import read_manifest
from harness.plan import Plan, check_experiment, expand
from harness.plugins import Registry, load_registry
from harness.results import Results
from harness.store import Store

DEFAULT_FOLDER = Path("results") / "runs"


def run(*, out: str | Path | None = None, jobs: int | None = None, **experiment: Any) -> Results:
    """Run every combination of an experiment that is not done yet.

    Args:
        out: The experiment's folder; by default one under ``results/runs/`` named for the plan, so that the same call
            goes on where an earlier one stopped.
        jobs: How many cells at once; by default as many as there are cores.
        **experiment: The fields of `harness.plan.Experiment`; the lists may be single names, or text with commas.

    Raises:
        UsageError: Something given cannot be used; nothing is written.
    """
    if jobs is not None and jobs < 1:
        raise UsageError(f"jobs={jobs}: must be at least 1")
    registry = load_registry()
    plan = expand(check_experiment(experiment), registry)
    store = Store.create(Path(out) if out else default_folder(plan), plan)
    run_plan(plan, store, registry, jobs or core_count())
    return Results(store.folder, registry)


def default_folder(plan: Plan) -> Path:
    """A folder named for what the plan does: the same plan finds its results again."""
    first = plan.cells[0] if plan.cells else plan.skipped[0][0]
    return DEFAULT_FOLDER / f"{first.simulator.name}-{first.algorithm.name}-{plan.id}"


def core_count() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0))


def run_plan(
    plan: Plan,
    store: Store,
    registry: Registry,
    jobs: int,
    on_event: OnEvent = lambda event: None,
    executor: str = "processes",
) -> None:
    """Do the cells of a plan that are not done yet.

    Args:
        plan: What to do.
        store: Where.
        registry: The plugins.
        jobs: How many cells at once.
        on_event: Told what happens to the cells.
        executor: Registered name of what runs them.
    """
    runner: Executor = registry.get("executors", executor).load()()
    with store.locked():
        store.discard_partial()
        waiting = [Job(cell, store.cell_folder(cell)) for cell in plan.cells if not store.is_done(cell)]

        def record(event: Event) -> None:
            if event.kind == "ended":
                if event.reason:
                    store.record(event.cell, "failed", event.reason)
                event = event._replace(reason=read_manifest(store.cell_folder(event.cell)).reason)
            on_event(event)

        try:
            runner.run(waiting, jobs, record)
        finally:
            store.discard_partial()
