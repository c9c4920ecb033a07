"""Says what a run would do: ``harness run --dry-run``."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from harness.eta.verdict.halving import Rung, Schedule, schedule_of
from harness.experiment.experiment import ExperimentRun
from harness.experiment.trials.measured_kind import Measured, horizon_in, measure_kinds
from harness.files.plain import Plain, tells
from harness.record.cell import Cell
from harness.record.folder import EVALUATION_RECORDING
from harness.record.pace import Kind, kind_of, time_left, took
from harness.record.store import Store
from harness.registry.choice import choose
from harness.results.comparison import Group
from harness.text import command_text

HERE = "processes"
"""The executor that trains on this machine."""


@tells("folder", "is_new", "left", "at_once", "seconds", "bytes", "unknown", "looks", "rungs", "measured", "memory")
@dataclass(frozen=True)
class Foreseen(Plain):
    """What a run would do.

    Attributes:
        folder: The experiment's.
        is_new: Whether it is not there yet.
        done: Cells that are not run again.
        to_do: Cells that are run, in this order.
        left: How many stay pending, because of the options ``only`` and ``limit``.
        skipped: Cells that cannot work, each with the reason.
        at_once: How many cells at once.
        seconds: How long the run will take, with so many cells at once, by the done cells of the same simulator and
            algorithm in the folder, or by a few steps that were measured now; None where there is neither.
        bytes: What all that is to do will leave, by the done cells; None where there is none.
        unknown: Why one of them is not known; empty where both are.
        measured: How many steps were measured now.
        horizon: Steps after which the environment itself ends an episode; 0 if it does not, or that is not known.
        memory: What the cells at once will have in memory, in bytes, by the largest one; 0 where that is not known.
        looks: Of an experiment with looks, the seeds at each of them: it ends where the answer stands, so that `to_do`
            is the most that there can be. Empty for others.
        is_choosing: Whether one of several rewards is chosen. Of `to_do` only the number is known then.
        schedule: How its budget is spent; None as long as that is not known.
    """

    folder: Path
    is_new: bool
    done: tuple[Cell, ...]
    to_do: tuple[Cell, ...]
    left: int
    skipped: tuple[tuple[Cell, str], ...] = field(default=())
    at_once: int = 1
    seconds: float | None = None
    bytes: float | None = None
    unknown: str = ""
    looks: tuple[int, ...] = ()
    is_choosing: bool = False
    schedule: Schedule | None = None
    measured: int = 0
    horizon: int = 0
    memory: int = 0

    @property
    def rungs(self) -> tuple[Rung, ...]:
        """The rungs of the schedule; none as long as it is not known."""
        return self.schedule.rungs if self.schedule else ()

    @property
    def candidates(self) -> tuple[str, ...]:
        """The rewards that are trained first."""
        cells = (*self.done, *self.to_do)
        return tuple(dict.fromkeys(it.reward.label for it in cells if it.seed == cells[0].seed))

    @property
    def basis(self) -> str:
        """What the time is estimated from."""
        return (
            f"by {self.measured:,} steps measured here just now" if self.measured else "estimated from the done cells"
        )

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            **super().to_json(),
            "done": [*map(_cell_to_json, self.done)],
            "to_do": [*map(_cell_to_json, self.to_do)],
            "skipped": [{**_cell_to_json(cell), "reason": reason} for cell, reason in self.skipped],
        }


def foresee(ready: ExperimentRun, *, measures: bool = False) -> Foreseen:
    """What a run would do now.

    Args:
        ready: The run.
        measures: Whether to train a few steps, in a temporary folder, of what no cell in the folder did.

    Raises:
        UsageError: It would be refused, because other plugins made done cells.
    """
    begun, store = ready.look(), ready.store
    to_do, left = begun.foreseen, len(ready.plan.cells) - len(begun.done) - len(set(begun.waiting) - set(begun.done))
    done = [manifest for manifest in store.manifests() if manifest.status == "done"]
    sizes = _bytes_per_step(store, [it.cell for it in done])
    missing = {kind_of(cell): cell for cell in reversed(to_do) if kind_of(cell) not in sizes}
    measured, reason = _measured(ready, [*missing.values()]) if measures and missing else ({}, "")
    ended = [*done, *(took(cell, *it.of_cell(cell)) for cell, it in measured.items())]
    is_known, setup = measured.keys() == {*missing.values()}, max((it.setup for it in measured.values()), default=0.0)
    peaks = [it.peak_memory for it in done if kind_of(it.cell) in map(kind_of, to_do)]
    peaks += [it.memory for it in measured.values()]
    seconds = time_left(ended, [], to_do, ready.options.at_once) if is_known else None
    unknown = _why_unknown(next(iter(missing.values())), reason) if missing else ""
    return Foreseen(
        store.folder,
        not Store.is_experiment(store.folder),
        begun.done,
        to_do,
        left,
        ready.plan.skipped,
        ready.options.at_once,
        None if seconds is None else seconds + setup,
        None if missing else sum(sizes[kind_of(cell)] * cell.steps for cell in to_do),
        unknown,
        ready.plan.terms.looks,
        bool(ready.plan.terms.budget),
        _schedule_of(ready),
        sum(it.steps for it in measured.values()),
        max([_horizon_of(store, begun.done), *(it.horizon for it in measured.values())]),
        min(ready.options.at_once, len(to_do)) * max(peaks, default=0),
    )


def _schedule_of(ready: ExperimentRun) -> Schedule | None:
    """How a budget of trainings is spent; None of one in minutes, before the first trainings have ended."""
    terms, skipped = ready.plan.terms, [cell for cell, _ in ready.plan.skipped]
    places = len({Group.of(it) for it in (*ready.plan.cells, *skipped)})
    return schedule_of(terms.asked, terms.budget, places) if terms.budget and not terms.seconds else None


def _measured(ready: ExperimentRun, cells: Sequence[Cell]) -> tuple[dict[Cell, Measured], str]:
    """What a few steps of each took, and why others were not measured."""
    options, registry = ready.options, ready.registry
    name = choose(registry, "executors", options.executor).name
    if name != HERE:
        return {}, f"the executor {name} trains elsewhere"
    in_environment = (it.task for it in cells if it.is_in_environment)
    together = [it.name for it in in_environment if hasattr(it.build(registry, "environments"), "make_together")]
    if together:
        return {}, f"{together[0]} starts a program, which is not done for an estimate"
    found = measure_kinds(cells, registry.given, options.at_once)
    reasons = [it for it in found.values() if isinstance(it, str)]
    told = f"a short training here failed: {reasons[0]}" if reasons else ""
    return {cell: it for cell, it in found.items() if isinstance(it, Measured)}, told


def _horizon_of(store: Store, done: Sequence[Cell]) -> int:
    """The horizon that the done cells of an environment recorded."""
    paths = (store.cell_folder(cell) / EVALUATION_RECORDING for cell in done if cell.is_in_environment)
    return next((horizon_in(path) for path in paths if path.is_dir()), 0)


def _why_unknown(cell: Cell, reason: str) -> str:
    names = f"{cell.place.name},{cell.algorithm.name}"
    flags = command_text("--only", names, "--limit", "1")
    besides = f", and {reason}" if reason else ""
    return f"no cell of {' · '.join(kind_of(cell))} is done in the folder yet{besides}. {flags} runs one"


def _bytes_per_step(store: Store, done: Sequence[Cell]) -> Mapping[Kind, float]:
    """What the done cells in a folder left for each step, by kind."""
    sizes, steps = defaultdict[Kind, float](float), defaultdict[Kind, int](int)
    for cell in done:
        files = store.cell_folder(cell).rglob("*")
        sizes[kind_of(cell)] += sum(path.stat().st_size for path in files if path.is_file())
        steps[kind_of(cell)] += cell.steps
    return {kind: size / steps[kind] for kind, size in sizes.items()}


def _cell_to_json(cell: Cell) -> dict[str, str]:
    return {"id": cell.id, "title": cell.title}
