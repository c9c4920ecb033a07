"""The done cells of an experiment, and what rewards and metrics say of each."""

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from functools import cached_property, partial

from harness.errors import SchemaError, Unscored
from harness.measure import Measure
from harness.record.cell import Cell
from harness.record.folder import EVALUATION, RANDOM, TRACE
from harness.record.manifest import Manifest
from harness.record.recording.recorded_training import recordings_in
from harness.record.store import Store
from harness.registry.choice import Choice
from harness.registry.registry import Registry
from harness.results.cell_results import CellResults, Floors
from harness.results.kept import Kept
from harness.results.measured import Values
from harness.results.metrics import load_metrics, with_fingerprints
from harness.results.recordings.recording_results import RecordingResults, numbers_in_environment
from harness.results.table import Numbers, metric_columns, numbers_of
from harness.score.installed_reward import InstalledReward


class DoneCells:
    """Reads the results of done cells. It reads again at each request."""

    def __init__(
        self, store: Store, registry: Registry, metrics: Iterable[str] | None = None, named: Sequence[str] = ()
    ) -> None:
        """Read nothing yet.

        Args:
            store: The folder of the experiment.
            registry: The plugins, for metrics and rewards.
            metrics: Which metrics; see `harness.results.metrics.load_metrics`.
            named: The measures that the experiment names; see there.

        Raises:
            UsageError: A named metric is not registered.
            PluginError: A named metric is broken.
        """
        self._store, self._registry, self._named = store, registry, named
        self._chosen = None if metrics is None else load_metrics(registry, metrics, named)
        self._rewards: dict[Choice, InstalledReward] = {}

    @cached_property
    def metrics(self) -> dict[str, Measure]:
        """Every registered metric, or those that were chosen, by name."""
        return load_metrics(self._registry, named=self._named) if self._chosen is None else self._chosen

    @property
    def columns(self) -> list[str]:
        """The columns of a table of cells that come first among those of numbers, although no cell may have them."""
        return metric_columns(self.metrics)

    def numbers(self, done: Manifest) -> Callable[[Values], Numbers]:
        """What the table of cells says of a done cell: a function of what random actions did there.

        The cell that acts at random may end later.
        """
        found = self.of(done)
        measured = found.measured({})
        found.finish()
        return lambda random: numbers_of(measured._replace(random=random), self.metrics)

    def floors(self, ended: Iterable[Manifest]) -> Callable[[Cell], Values]:
        """What random actions did, a function of the cell."""
        known = {manifest.cell: manifest for manifest in ended}
        return Floors(self._store, known.values(), lambda cell: self.of(known[cell])).of

    def of(self, done: Manifest) -> CellResults:
        """The results of a done cell."""
        files = self._store.cell_folder(done.cell)
        kept = Kept(self._store.folder, done.cell.id, files, done.files)
        return CellResults(done, files, lambda: self._fingerprinted, kept)

    def installed(self, choice: Choice) -> InstalledReward:
        """What pays recorded runs again by a reward."""
        if choice not in self._rewards:
            self._rewards[choice] = InstalledReward(choice, self._registry)
        return self._rewards[choice]

    def keep(self, done: Manifest, compared: Iterable[Choice], scoring: Iterable[Choice]) -> None:
        """Compute what a report will ask of a cell, and keep it.

        Args:
            done: What a done cell says of itself.
            compared: The rewards that its training is paid by.
            scoring: The rewards that its evaluation is paid by, and its random actions.

        Raises:
            SchemaError: A file of the cell is damaged.
        """
        found, cell = self.of(done), done.cell
        found.require_plausible()
        found.measured(found.floor() if found.has_floor else {})
        if cell.evaluate_every:
            found.moments()
        found.keep_own()
        files = (EVALUATION, *([RANDOM] if found.has_floor else ()))
        own, payers = self.installed(cell.reward), list(map(self.installed, scoring))
        jobs: list[Callable[[], object]] = [
            *(partial(found.pays_recorded, own, file) for file in (TRACE, EVALUATION)),
            *(partial(found.paid_by, self.installed(choice)) for choice in compared),
            *(partial(found.evaluation_return, it) for it in payers),
            *(partial(found.floor_returns, it) for it in payers if found.has_floor),
            *(partial(found.terms_paid, own, file) for file in ((TRACE, *files) if found.term_names() else ())),
            *(partial(found.terms_paid, it, file) for it in payers if it is not own and it.has_terms for file in files),
        ]
        for job in jobs:
            with suppress(Unscored):  # the report says so
                job()
        found.finish()

    @cached_property
    def _fingerprinted(self) -> dict[str, tuple[Measure, str]]:
        return with_fingerprints(self.metrics)


class DoneRecordings:
    """Reads the recordings of done cells; see `DoneCells`, which has the same members."""

    columns: tuple[str, ...] = ()

    def __init__(self, store: Store) -> None:
        """Read nothing yet."""
        self._store = store

    def numbers(self, done: Manifest) -> Callable[[Values], Numbers]:
        """Random actions have no columns here."""
        found = numbers_in_environment(self._store.folder, self._store.cell_folder(done.cell))
        return lambda random: found

    def floors(self, ended: Iterable[Manifest]) -> Callable[[Cell], Values]:
        return lambda cell: {}

    def keep(self, done: Manifest, compared: Iterable[Choice], scoring: Iterable[Choice]) -> None:
        """Keep what follows from the recordings of a cell; see `DoneCells`. All rewards have paid them already."""
        for path in recordings_in(self._store.cell_folder(done.cell)):
            with suppress(SchemaError):  # the report says so
                RecordingResults(self._store.folder, path).keep()
