"""The records of the cells in an experiment's folder, each read once."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path

from harness.arrays import Float
from harness.errors import NewerFormat, SchemaError
from harness.eta.curve import GroupCurve, Kind, stream_curve
from harness.eta.equal import Key, equal_trainings
from harness.files.bounded import read_text, reading
from harness.log import Log
from harness.measure import Measure
from harness.record.cell import Cell
from harness.record.cell_folder import REMEDY
from harness.record.folder import TRACE
from harness.record.manifest import Manifest
from harness.record.plan_file import EXPERIMENT
from harness.record.store import Store
from harness.registry.choice import Choice
from harness.registry.given import plugin_flags
from harness.registry.registry import Registry
from harness.results.cell_results import CellResults
from harness.results.comparison import Group
from harness.results.done_cells import DoneCells
from harness.results.floors import Floors
from harness.results.measured import Measured, Moment, Values, measure
from harness.results.metrics import named_measures
from harness.score.installed_reward import InstalledReward


class Records:
    """The cells of an experiment, as its folder records them."""

    def __init__(
        self,
        folder: Path,
        registry: Registry,
        kind: Kind = "accumulated",
        *,
        metrics: Iterable[str] | None = None,
        is_temporary: bool = False,
        store: Store | None = None,
        pairs: bool = False,
    ) -> None:
        """Read the plan and all manifests.

        Args:
            folder: The folder of the experiment.
            registry: The plugins, for metrics and rewards.
            kind: Which curves the indices are read from; see `harness.eta.curve.GroupCurve`.
            metrics: Which metrics; every registered one if None, see `harness.results.metrics.load_metrics`.
            is_temporary: Whether the folder is soon gone, so that no command may name it.
            store: Reads the folder; by default as that of an experiment.
            pairs: Whether every two rewards are compared, and not each with the baseline alone.

        Raises:
            UsageError: The folder is no experiment's, or a named metric is not registered.
            PluginError: A named metric is broken.
            SchemaError: A newer version wrote a file in it, or its plan is damaged and the cells do not tell either.
        """
        self.folder = folder
        self.store = store or Store.open(folder)
        self.registry = registry
        self.kind: Kind = kind
        self.is_temporary = is_temporary
        self.pairs = pairs
        self.plan = self.store.read_plan()
        self.baseline = self.plan.baseline
        self._measured: dict[str, Measured] = {}
        self._moments: dict[str, tuple[Moment, ...]] = {}
        self._found: dict[str, CellResults] = {}
        self._curves: dict[tuple[str, ...], GroupCurve] = {}
        self.named = named_measures(self.plan.experiment)
        self._cells = DoneCells(self.store, registry, metrics, self.named)
        self.manifests = [self._examine(cell) for cell in self.plan.cells]
        self._ended = {manifest.cell.id: manifest for manifest in self.manifests}

    @property
    def metrics(self) -> Mapping[str, Measure]:
        """Every registered metric, or those that were chosen, by name."""
        return self._cells.metrics

    @property
    def measures(self) -> tuple[str, ...]:
        """The names of all measures of behaviour."""
        return tuple(self.metrics)

    @property
    def is_experiment(self) -> bool:
        """Whether an experiment made what the folder holds, so that it can be repeated."""
        return Store.is_experiment(self.folder)

    @property
    def not_measured(self) -> dict[str, str]:
        """Why each metric failed in a done cell, from the first such cell."""
        reasons: dict[str, str] = {}
        for manifest in self.done:
            reasons = {**self.measured(manifest.cell).reasons, **reasons}
        return reasons

    @property
    def failed(self) -> list[Manifest]:
        """Cells that failed."""
        return [manifest for manifest in self.manifests if manifest.status == "failed"]

    @property
    def damaged(self) -> list[Manifest]:
        """Cells with a file that is not what was written. Nothing is read of them."""
        return [manifest for manifest in self.manifests if manifest.status == "damaged"]

    @property
    def experiment_text(self) -> str:
        """The newest experiment as an experiment file. In a folder of version 0.1 it is the text of the file itself.

        Raises:
            SchemaError: That file cannot be read.
        """
        path = self.folder / EXPERIMENT
        if self.plan.experiment or not path.is_file():
            return self.plan.experiment_text
        with reading(path, "experiment file"):
            return read_text(path)

    @property
    def plugin_flags(self) -> str:
        """The flags that give the plugins of the newest experiment, to be appended to ``harness run``; often empty."""
        return plugin_flags(self.plan.experiment.get("plugins"))

    @property
    def report_flags(self) -> str:
        """Those of them that a report needs."""
        return plugin_flags(self.plan.experiment.get("plugins"), for_report=True)

    @property
    def done(self) -> list[Manifest]:
        """Cells that left a trace."""
        return [manifest for manifest in self.manifests if manifest.status == "done"]

    @cached_property
    def groups(self) -> dict[Group, list[Cell]]:
        """Cells that left a trace, by the group in which they are compared."""
        groups: dict[Group, list[Cell]] = {}
        for manifest in self.done:
            groups.setdefault(Group.of(manifest.cell), []).append(manifest.cell)
        return groups

    @cached_property
    def equal(self) -> dict[Group, tuple[tuple[Key, ...], ...]]:
        """Trainings of an arm that left the same trace, bit for bit, by their group."""
        digests: dict[Group, dict[Key, str]] = {}
        for manifest in self.done:
            key = (manifest.cell.reward.label, manifest.cell.seed)
            digests.setdefault(Group.of(manifest.cell), {})[key] = manifest.files.get(TRACE, "")
        found = {group: equal_trainings(of) for group, of in digests.items()}
        return {group: equal for group, equal in found.items() if equal}

    @property
    def done_cells(self) -> list[Cell]:
        """The same, without the cells that only the null control needs."""
        return [manifest.cell for manifest in self.done if not self.is_control(manifest.cell)]

    def is_control(self, cell: Cell) -> bool:
        """Whether only the null control needs a cell: the baseline trained again with another seed."""
        control = self.plan.control
        return cell.reward.label == self.baseline and cell.seed in control.values() and cell.seed not in control

    def manifest(self, cell: Cell) -> Manifest:
        """The manifest of a planned cell."""
        return self._ended[cell.id]

    def measure(self, trace: Log) -> Values:
        """Every metric of an evaluation."""
        return measure(self.metrics, trace)

    def measured(self, cell: Cell) -> Measured:
        """Every metric of a done cell."""
        if cell.id not in self._measured:
            found = self.of(cell)
            self._measured[cell.id] = found.measured({**dict.fromkeys(self.metrics), **self._floors.of(cell)})
            if found.has_read:
                found.keep_own()  # columns are there now
            found.finish()
        return self._measured[cell.id]

    def floor_returns(self, cell: Cell, reward: InstalledReward) -> Float:
        """What a reward pays each episode of random actions where a done cell trained, (episodes,); see `Floors`."""
        return self._floors.returns(cell, reward)

    def moments(self, cell: Cell) -> tuple[Moment, ...]:
        """Every evaluation of a done cell during its training, and the one after it."""
        if cell.id not in self._moments:
            self._moments[cell.id] = self.of(cell).moments()
            self.of(cell).finish()
        return self._moments[cell.id]

    def learned(self, cell: Cell) -> Float:
        """The finished episodes of a done cell's training, (3, episodes); see `CellResults.learned`."""
        learned = self.of(cell).learned()
        self.of(cell).finish()
        return learned

    def recorded(self, cell: Cell) -> Float:
        """What a done cell's own reward paid, every row of its training, (rows,)."""
        return self.of(cell).recorded()

    def of(self, cell: Cell) -> CellResults:
        """The results of a done cell."""
        if cell.id not in self._found:
            self._found[cell.id] = self._cells.of(self._ended[cell.id])
        return self._found[cell.id]

    def installed(self, choice: Choice) -> InstalledReward:
        """What pays recorded runs again by a reward."""
        return self._cells.installed(choice)

    def floor_of(self, cell: Cell) -> Cell | None:
        """The cell that evaluated random actions in the place of a done cell; None if no cell did."""
        return self._floors.owner(cell)

    def curve(self, cells: Sequence[Cell]) -> GroupCurve:
        """The curve of done cells' trainings, as they were paid. It is kept, since many rewards share one baseline."""
        key = tuple(cell.id for cell in cells)
        found = self._curves.pop(key, None) or self._curve(cells, lambda of: of.recorded())
        self._curves = {**dict(list(self._curves.items())[-1:]), key: found}  # only the last two are kept
        return found

    def curve_paid_by(self, reward: InstalledReward, cells: Sequence[Cell]) -> GroupCurve:
        """The curve of done cells' trainings, as another reward would have paid them.

        Raises:
            Unscored: It cannot.
        """
        return self._curve(cells, lambda of: of.paid_by(reward))

    def _examine(self, cell: Cell) -> Manifest:
        """What there is to say of a cell. Files that are what was written may still hold what no cell can have done."""
        manifest = self.store.examine(cell)
        if manifest.status != "done":
            return manifest
        try:
            found = self._found[cell.id] = self._cells.of(manifest)
            found.require_plausible()
        except NewerFormat:
            raise
        except SchemaError as error:
            return Manifest(cell, status="damaged", reason=f"{error}; {REMEDY}")
        return manifest

    @cached_property
    def _floors(self) -> Floors:
        return Floors(self.store, self.manifests, self.of)

    def _curve(self, cells: Sequence[Cell], rewards: Callable[[CellResults], Float]) -> GroupCurve:
        """The curve of cells. Only one run at a time is in memory."""
        rows = min(self.of(cell).rows() for cell in cells)
        return stream_curve(self._runs(cells, rewards), len(cells), rows, self.kind)

    def _runs(self, cells: Sequence[Cell], rewards: Callable[[CellResults], Float]) -> Iterator[Float]:
        for cell in cells:
            yield rewards(self.of(cell))
            self.of(cell).finish()
