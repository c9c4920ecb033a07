"""The done cells of an experiment in environments, for whoever keeps their results while the experiment goes on."""

from collections.abc import Callable, Iterable
from contextlib import suppress

from harness.errors import SchemaError
from harness.record.cell import Cell
from harness.record.manifest import Manifest
from harness.record.recording.recorded_training import recordings_in
from harness.record.store import Store
from harness.registry.choice import Choice
from harness.results.measured import Values
from harness.results.recordings.recording_results import RecordingResults, numbers_in_environment
from harness.results.table import Numbers


class DoneRecordings:
    """Reads the recordings of done cells; see `harness.results.done_cells.DoneCells`, which has the same members."""

    columns: tuple[str, ...] = ()

    def __init__(self, store: Store) -> None:
        """Read nothing yet."""
        self._store = store

    def numbers(self, done: Manifest) -> Callable[[Values], Numbers]:
        """See `DoneCells`; random actions have no columns here."""
        found = numbers_in_environment(self._store.folder, self._store.cell_folder(done.cell))
        return lambda random: found

    def floors(self, ended: Iterable[Manifest]) -> Callable[[Cell], Values]:
        """See `DoneCells`."""
        return lambda cell: {}

    def keep(self, done: Manifest, compared: Iterable[Choice], scoring: Iterable[Choice]) -> None:
        """Keep what follows from the recordings of a cell; see `DoneCells`. All rewards have paid them already."""
        for path in recordings_in(self._store.cell_folder(done.cell)):
            with suppress(SchemaError):  # the report says so
                RecordingResults(self._store.folder, path).keep()
