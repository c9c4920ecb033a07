"""What the cells in an experiment's folder left, read once."""

from collections.abc import Iterable
from functools import cached_property
from pathlib import Path

from harness.eta.curve import Kind
from harness.files.bounded import read_text
from harness.metric import Metric
from harness.record.cell import Cell
from harness.record.folder import TRACE
from harness.record.manifest import Manifest
from harness.record.plan_file import EXPERIMENT
from harness.record.store import Store
from harness.record.trace import Trace, read_trace
from harness.registry.choice import build_defaults
from harness.registry.registry import Registry
from harness.results.measured import Measured, Moment, Values, measure, measure_cell, moments_of
from harness.score.scorer import SCORED


class Records:
    """An experiment's cells as its folder tells them."""

    def __init__(self, folder: Path, registry: Registry, kind: Kind = "accumulated") -> None:
        """Read the plan and all manifests.

        Args:
            folder: The experiment's.
            registry: The plugins, for metrics and rewards.
            kind: Which curves the indices are read from; see `harness.eta.curve.GroupCurve`.

        Raises:
            UsageError: The folder is no experiment's.
            SchemaError: A newer version wrote a file in it, or its plan is damaged and the cells do not tell either.
        """
        self.folder = folder
        self.store = Store.open(folder)
        self.registry = registry
        self.kind: Kind = kind
        self.plan = self.store.read_plan()
        self.baseline = self.plan.baseline
        self.manifests = [self.store.examine(cell) for cell in self.plan.cells]
        self._measured: dict[str, Measured] = {}
        self._moments: dict[str, tuple[Moment, ...]] = {}

    @cached_property
    def metrics(self) -> dict[str, Metric]:
        """Every registered metric, by name."""
        return build_defaults(self.registry, "metrics")

    @property
    def failed(self) -> list[Manifest]:
        """Cells that failed."""
        return [manifest for manifest in self.manifests if manifest.status == "failed"]

    @property
    def damaged(self) -> list[Manifest]:
        """Cells of which a file is not what was written; nothing is read of them."""
        return [manifest for manifest in self.manifests if manifest.status == "damaged"]

    @property
    def experiment_text(self) -> str:
        """The newest experiment as an experiment file; the file's own text in a folder of version 0.1."""
        path = self.folder / EXPERIMENT
        if self.plan.experiment or not path.is_file():
            return self.plan.experiment_text
        return read_text(path)

    @property
    def done(self) -> list[Manifest]:
        """Cells that left a trace."""
        return [manifest for manifest in self.manifests if manifest.status == "done"]

    @property
    def done_cells(self) -> list[Cell]:
        """The same, those left out that only the null control is for."""
        return [manifest.cell for manifest in self.done if not self.is_control(manifest.cell)]

    def is_control(self, cell: Cell) -> bool:
        """Whether a cell is there for the null control alone: the baseline trained again with another seed."""
        control = self.plan.control
        return cell.reward.label == self.baseline and cell.seed in control.values() and cell.seed not in control

    def measure(self, trace: Trace) -> Values:
        """Every metric of an evaluation."""
        return measure(self.metrics, trace)

    def measured(self, cell: Cell) -> Measured:
        """Every metric of a done cell."""
        if cell.id not in self._measured:
            self._measured[cell.id] = measure_cell(self.metrics, cell, self.store.cell_folder(cell))
        return self._measured[cell.id]

    def moments(self, cell: Cell) -> tuple[Moment, ...]:
        """Every evaluation of a done cell while it learned, and the one after."""
        if cell.id not in self._moments:
            self._moments[cell.id] = moments_of(self.metrics, cell, self.store.cell_folder(cell))
        return self._moments[cell.id]

    def traces(self, cells: Iterable[Cell]) -> list[Trace]:
        """Training traces of done cells, with the columns that a reward is computed from."""
        return [read_trace(self.store.cell_folder(cell) / TRACE, [*SCORED, "reward"]) for cell in cells]
