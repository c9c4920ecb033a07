"""What a report needs, made as cells end."""

import pytest

from harness.experiment.plan import check_experiment, expand
from harness.record import DERIVED
from harness.results.cell_results import CellResults

GIVEN = {
    "sim": "ideal", "algo": "wander", "task": "fd100-reach:horizon=5", "seeds": 1, "steps": 12,
    "evaluation_episodes": 3, "reward": "arp,dense",
}  # fmt: skip


def paid_trainings(results):
    """By the reward of a cell, how many arrays are kept: its episodes, and what each reward paid, its own too."""
    folders = {cell.reward.label: results.folder / DERIVED / cell.id for cell in results.done_cells}
    return {label: len(list(folder.glob("*.array"))) for label, folder in folders.items()}


def test_trainings_are_paid_by_what_they_are_compared_with(toys, run_here, tmp_path):
    """The baseline's by every proposed reward, the others by the baseline's, each by its own."""
    results = run_here(expand(check_experiment(GIVEN), toys), tmp_path / "out")
    assert paid_trainings(results) == {"baseline": 4, "arp": 3, "dense": 3}


def test_nothing_is_kept_of_a_failed_cell(toys, run_here, tmp_path):
    """It has nothing to measure."""
    results = run_here(expand(check_experiment({**GIVEN, "algo": "wander:then=raise"}), toys), tmp_path / "out")
    assert len(results.failed) == 3
    assert not (tmp_path / "out" / DERIVED).exists()


def test_metric_that_raises_stops_no_run(toys, run_here, tmp_path, monkeypatch):
    """The cells are done; whoever reports meets the error."""

    def fail(self):
        raise ZeroDivisionError("a metric's own fault")

    monkeypatch.setattr(CellResults, "_manners", property(fail))
    results = run_here(expand(check_experiment(GIVEN), toys), tmp_path / "out")
    assert len(results.done) == 3
    with pytest.raises(ZeroDivisionError):
        _ = results.combinations
