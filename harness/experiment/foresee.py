"""Says what a run would do: ``harness run --dry-run``."""

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from harness.experiment.experiment import ExperimentRun
from harness.record.cell import Cell
from harness.record.store import Store
from harness.text import command_text

Kind: TypeAlias = tuple[str, str]
"""Labels of simulator, or environment, and algorithm: what decides how long a step takes, and how much it leaves."""


class Cost(NamedTuple):
    """The cost of cells, past or expected."""

    seconds: float
    bytes: float

    def __add__(self, other: "Cost") -> "Cost":  # type: ignore[override]
        return Cost(self.seconds + other.seconds, self.bytes + other.bytes)

    def times(self, factor: float) -> "Cost":
        """The cost times `factor`."""
        return Cost(self.seconds * factor, self.bytes * factor)


NOTHING = Cost(0.0, 0.0)


@dataclass(frozen=True)
class Foreseen:
    """What a run would do.

    Attributes:
        folder: The experiment's.
        is_new: Whether it is not there yet.
        done: Cells that are not run again.
        to_do: Cells that are run, in this order.
        left: How many stay pending, because of the options ``only`` and ``limit``.
        skipped: Cells that cannot work, each with the reason.
        at_once: How many cells at once.
        cost: Of all that is to do: of one cell after the other, by the done cells of the same simulator and algorithm
            in the folder; None where there is none.
        unknown: Why there is no cost; empty where there is one.
        looks: Of an experiment with looks, the seeds at each of them: it ends where the answer stands, so that `to_do`
            is the most that there can be. Empty for others.
    """

    folder: Path
    is_new: bool
    done: tuple[Cell, ...]
    to_do: tuple[Cell, ...]
    left: int
    skipped: tuple[tuple[Cell, str], ...] = field(default=())
    at_once: int = 1
    cost: Cost | None = None
    unknown: str = ""
    looks: tuple[int, ...] = ()

    @property
    def seconds(self) -> float | None:
        """How long the run will take, with so many cells at once."""
        return self.cost and self.cost.seconds / max(1, min(self.at_once, len(self.to_do)))

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "folder": str(self.folder),
            "is_new": self.is_new,
            "done": [_cell_to_json(cell) for cell in self.done],
            "to_do": [_cell_to_json(cell) for cell in self.to_do],
            "left": self.left,
            "skipped": [{**_cell_to_json(cell), "reason": reason} for cell, reason in self.skipped],
            "at_once": self.at_once,
            "seconds": self.seconds,
            "bytes": self.cost and self.cost.bytes,
            "unknown": self.unknown,
            "looks": list(self.looks),
        }


def foresee(ready: ExperimentRun) -> Foreseen:
    """What a run would do now.

    Raises:
        UsageError: It would be refused, because other plugins made done cells.
    """
    begun, store = ready.look(), ready.store
    missing, costs = None, _costs_per_step(store)
    for cell in begun.waiting:
        if _kind(cell) not in costs:
            missing = cell
    cost = NOTHING
    for cell in begun.waiting if missing is None else ():
        cost += costs[_kind(cell)].times(cell.steps)
    return Foreseen(
        store.folder,
        not Store.is_experiment(store.folder),
        begun.done,
        begun.waiting,
        len(ready.plan.cells) - len(begun.done) - len(set(begun.waiting) - set(begun.done)),
        ready.plan.skipped,
        ready.options.at_once,
        cost if missing is None else None,
        _why_unknown(missing) if missing else "",
        ready.plan.terms.looks,
    )


def _why_unknown(cell: Cell) -> str:
    names = f"{cell.place.name},{cell.algorithm.name}"
    flags = command_text("--only", names, "--limit", "1")
    return f"no cell of {' · '.join(_kind(cell))} is done in the folder yet. {flags} runs one"


def _costs_per_step(store: Store) -> Mapping[Kind, Cost]:
    """The costs per step of the done cells in a folder, by kind."""
    done = [manifest for manifest in store.manifests() if manifest.status == "done"]
    costs: dict[Kind, Cost] = defaultdict(lambda: NOTHING)
    steps: dict[Kind, int] = defaultdict(int)
    for manifest in done:
        files = store.cell_folder(manifest.cell).rglob("*")
        size = sum(path.stat().st_size for path in files if path.is_file())
        costs[_kind(manifest.cell)] += Cost(manifest.seconds, size)
        steps[_kind(manifest.cell)] += manifest.cell.steps
    return {kind: cost.times(1.0 / steps[kind]) for kind, cost in costs.items()}


def _kind(cell: Cell) -> Kind:
    return cell.place.label, cell.learner


def _cell_to_json(cell: Cell) -> dict[str, str]:
    return {"id": cell.id, "title": cell.title}
