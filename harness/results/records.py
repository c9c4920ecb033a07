"""The records of the cells in an experiment's folder, each read once."""

from functools import cached_property
from pathlib import Path

from harness.eta.curve import Kind
from harness.eta.equal import Key, equal_trainings
from harness.record.cell import BROUGHT, EVALUATION_HORIZON, Cell
from harness.record.folder import TRACE
from harness.record.manifest import Manifest
from harness.record.plan_file import StoredPlan
from harness.record.store import Store
from harness.registry.choice import Choice
from harness.registry.given import plugin_flags
from harness.registry.registry import Registry
from harness.results.comparison import Group
from harness.results.metrics import named_measures
from harness.results.recordings.runs import Runs


class Records:
    """The cells of an experiment, as its folder records them."""

    def __init__(
        self,
        folder: Path,
        registry: Registry,
        kind: Kind = "accumulated",
        *,
        is_temporary: bool = False,
        runs: Runs | None = None,
        pairs: bool = False,
    ) -> None:
        """Read the plan and all manifests.

        Args:
            folder: The folder of the experiment.
            registry: The plugins, for metrics and rewards.
            kind: Which curves the indices are read from; see `harness.eta.curve.GroupCurve`.
            is_temporary: Whether the folder is soon gone, so that no command may name it.
            runs: The recordings or logs that it holds; None of an experiment.
            pairs: Whether every two rewards are compared, and not each with the baseline alone.

        Raises:
            UsageError: The folder is no experiment's.
            SchemaError: A newer version wrote a file in it, or its plan is damaged and the cells do not tell either.
        """
        self.folder = folder
        self.runs = runs
        self.store = Store(folder) if runs else Store.open(folder)
        self.registry = registry
        self.kind: Kind = kind
        self.is_temporary = is_temporary
        self.pairs = pairs
        self.plan = _plan_of(runs) if runs else self.store.read_plan()
        self.baseline = self.plan.baseline
        self.named = named_measures(self.plan.experiment)
        self.manifests = [Manifest(it, status="done") if runs else self.store.examine(it) for it in self.plan.cells]

    @property
    def is_experiment(self) -> bool:
        """Whether an experiment made what is read, so that it can be repeated."""
        return self.runs is None

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
        """The newest experiment as an experiment file."""
        return self.plan.experiment_text

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
        found = {
            group: equal_trainings(
                {(cell.reward.label, cell.seed): self.manifest(cell).files.get(TRACE, "") for cell in cells}
            )
            for group, cells in self.groups.items()
        }
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

    @cached_property
    def _ended(self) -> dict[str, Manifest]:
        return {manifest.cell.id: manifest for manifest in self.manifests}


def _plan_of(runs: Runs) -> StoredPlan:
    """A plan of trainings that no experiment made; the reward that was given first is the baseline."""
    group = runs.group
    cells = (
        Cell(
            *BROUGHT, group.task, group.algorithm, Choice(reward, (), reward), seed, group.steps,
            group.evaluation_episodes, evaluation_horizon=EVALUATION_HORIZON,
        )
        for reward, seed in runs.members
    )  # fmt: skip
    return StoredPlan(runs.trained[0], False, {}, tuple(cells), {})
