"""`results.parquet` while cells run."""

import pyarrow.parquet as pq
import pytest

from harness.experiment.followed import EVERY, EndedCells
from harness.experiment.plan import check_experiment, expand
from harness.experiment.verify import verify
from harness.record import RESULTS, Store, read_manifest
from harness.results.cell_results import CellResults

GIVEN = {
    "sim": "ideal", "algo": "wander", "task": "fd100-reach:horizon=5", "seeds": 2, "steps": 12,
    "evaluation_episodes": 3, "reward": "arp",
}  # fmt: skip


class Clock:
    """Stands still unless it is told to go on."""

    now = 0.0

    def __call__(self):
        """Seconds."""
        return self.now


@pytest.fixture
def plan(toys):
    """Four cells."""
    return expand(check_experiment(GIVEN), toys)


def statuses(folder):
    """What the table says of the cells."""
    return sorted(pq.read_table(folder / RESULTS)["status"].to_pylist())


class Killed(Exception):
    """Stands for what ends a run half-way."""


def test_run_that_is_interrupted_leaves_the_table_of_what_ended(run_here, plan, tmp_path):
    """A row per cell; those that did not get their turn are pending."""
    ended = []

    def on_event(event):
        if event.kind == "started" and len(ended) == 2:
            raise Killed
        ended.extend([event.cell] * (event.kind == "ended"))

    with pytest.raises(Killed):
        run_here(plan, tmp_path, on_event)
    assert statuses(tmp_path) == ["done", "done", "pending", "pending"]
    assert verify(tmp_path) == []


def test_first_cell_that_ends_is_in_the_table_at_once(run_here, plan, tmp_path):
    """Whatever happens to the process then."""
    seen = []

    def on_event(event):
        if event.kind == "ended":
            seen.append(statuses(tmp_path))

    run_here(plan, tmp_path, on_event)
    assert seen[0] == ["done", "pending", "pending", "pending"]


def test_table_at_the_end_is_that_of_the_results(run_here, plan, tmp_path):
    """Byte for byte: it does not matter who wrote it."""
    results = run_here(plan, tmp_path)
    so_far = (tmp_path / RESULTS).read_bytes()
    assert results.write_table().read_bytes() == so_far


def test_failed_cell_is_in_the_table(toys, run_here, tmp_path):
    """With its reason."""
    run_here(expand(check_experiment({**GIVEN, "algo": "wander:then=raise"}), toys), tmp_path)
    assert statuses(tmp_path) == ["failed"] * 4
    assert all(pq.read_table(tmp_path / RESULTS)["reason"].to_pylist())


def test_cells_of_an_earlier_experiment_stay_in_the_table(toys, run_here, plan, tmp_path):
    """They were done before, and are not asked for again."""
    run_here(plan, tmp_path)
    run_here(expand(check_experiment({**GIVEN, "seeds": [7], "reward": []}), toys), tmp_path)
    assert statuses(tmp_path) == ["done"] * 5


@pytest.fixture
def table(toys, run_here, plan, tmp_path):
    """Of an experiment whose cells are done, and whose table is not there."""
    run_here(plan, tmp_path)
    (tmp_path / RESULTS).unlink()
    store, clock = Store(tmp_path), Clock()
    return EndedCells(store, toys, clock=clock), clock, store


def test_table_is_written_anew_after_some_time_alone(table, plan):
    """However many cells end: with many cells each table takes its time."""
    so_far, clock, store = table
    path = store.folder / RESULTS
    manifests = [read_manifest(store.cell_folder(cell)) for cell in plan.cells]
    so_far.add(manifests[0])
    path.unlink()
    so_far.add(manifests[1])
    assert not path.exists()
    clock.now = EVERY
    so_far.refresh()
    assert statuses(store.folder) == ["done"] * 4


def test_table_that_lacks_nothing_is_not_written(table):
    """However much time has passed."""
    so_far, clock, store = table
    clock.now = 10 * EVERY
    so_far.refresh()
    so_far.write()
    assert not (store.folder / RESULTS).exists()


def test_cell_is_measured_once(table, plan, monkeypatch):
    """Its row is kept for the next tables."""
    so_far, _, store = table
    asked = []
    measured = CellResults._manners.func
    monkeypatch.setattr(CellResults._manners, "func", lambda of: (asked.append(of.cell.id), measured(of))[1])
    so_far.add(read_manifest(store.cell_folder(plan.cells[0])))
    so_far.add(read_manifest(store.cell_folder(plan.cells[1])))
    so_far.write()
    assert asked == [cell.id for cell in plan.cells]
