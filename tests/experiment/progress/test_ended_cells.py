"""What a report needs, made as cells end."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from harness.experiment.plan import check_experiment, expand
from harness.record.folder import DERIVED
from harness.registry.registry import Registry
from harness.results import Results
from harness.results.cell_results import CellResults
from harness.results.measured import Values

GIVEN: dict[str, Any] = {
    "sim": "ideal", "algo": "wander", "task": "fd100-reach:horizon=5", "seeds": 1, "steps": 12,
    "evaluation_episodes": 3, "reward": "arp,dense",
}  # fmt: skip


def paid_trainings(results: Results) -> dict[str, int]:
    """By the reward of a cell, how many arrays are kept: its episodes, and what each reward paid, its own too."""
    folders = {cell.reward.label: results.folder / DERIVED / cell.id for cell in results.done_cells}
    return {label: len(list(folder.glob("*.array"))) for label, folder in folders.items()}


def test_trainings_are_paid_by_what_they_are_compared_with(
    toys: Registry, run_here: Callable[..., Results], tmp_path: Path
):
    """The baseline's by every proposed reward, the others by the baseline's, each by its own."""
    results = run_here(expand(check_experiment(GIVEN), toys), tmp_path / "out")
    assert paid_trainings(results) == {"baseline": 4, "arp": 3, "dense": 3}


def test_nothing_is_kept_of_a_failed_cell(toys: Registry, run_here: Callable[..., Results], tmp_path: Path):
    """It has nothing to measure."""
    results = run_here(expand(check_experiment({**GIVEN, "algo": "wander:then=raise"}), toys), tmp_path / "out")
    assert len(results.failed) == 3
    assert not (tmp_path / "out" / DERIVED).exists()


def test_metric_that_raises_stops_no_run(
    toys: Registry, run_here: Callable[..., Results], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """The cells are done; whoever reports meets the error."""

    def fail(self: CellResults, floor: Values) -> None:
        raise ZeroDivisionError("a metric's own fault")

    monkeypatch.setattr(CellResults, "measured", fail)
    results = run_here(expand(check_experiment(GIVEN), toys), tmp_path / "out")
    assert len(results.done) == 3
    with pytest.raises(ZeroDivisionError):
        _ = results.combinations
