"""What a matrix costs beside its trainings: two jobs against one, and a cell's time that is no training."""

import statistics
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from harness.executor import CellOptions, Job
from harness.experiment.jobs import run_jobs
from harness.experiment.plan import check_experiment, expand
from harness.record.cell import Cell
from harness.record.manifest import read_manifest
from harness.registry.registry import load_registry

pytestmark = pytest.mark.bench

CELLS, STEPS = 8, 5000
SPEED_UP, OVERHEAD = 1.9, 2.0
"""Cells per hour of two jobs against one; seconds of a cell that are no training, with 100 episodes of evaluation."""


@pytest.fixture
def cells(amount: Callable[[int, int], int]) -> tuple[Cell, ...]:
    """Trainings of `sac-fast` with an evaluation of 100 episodes each; next to nothing where no bound holds."""
    asked = {"sim": "mujoco", "algo": "sac-fast", "reward": [], "seeds": amount(CELLS, 2), "steps": amount(STEPS, 20)}
    return expand(check_experiment({**asked, "evaluation_episodes": amount(100, 2)}), load_registry()).cells


def _seconds(cells: tuple[Cell, ...], folder: Path, at_once: int) -> float:
    jobs = [Job(cell, folder / cell.id, CellOptions(floor=number == 0)) for number, cell in enumerate(cells)]
    began = time.perf_counter()
    run_jobs(jobs, at_once, lambda event: None)
    return time.perf_counter() - began


def test_two_jobs_do_twice_as_much(cells: tuple[Cell, ...], tmp_path: Path, is_timed: bool):
    """Processes that start are counted in both."""
    one, two = (_seconds(cells, tmp_path / str(at_once), at_once) for at_once in (1, 2))
    print(f"\n{len(cells)} cells: {one:.1f} s with one job, {two:.1f} s with two: {one / two:.2f} times")  # noqa: T201
    assert not is_timed or one / two >= SPEED_UP


def test_a_cell_costs_little_beside_its_training(cells: tuple[Cell, ...], tmp_path: Path, is_timed: bool):
    """The first one of a process with the start of it; the median of those that follow."""
    cells = cells[:4]
    first = _seconds(cells[:1], tmp_path / "first", 1)
    training = read_manifest(tmp_path / "first" / cells[0].id).training_seconds
    _seconds(cells, tmp_path / "all", 1)
    manifests = [read_manifest(tmp_path / "all" / cell.id) for cell in cells[1:]]
    warm = statistics.median(manifest.seconds - manifest.training_seconds for manifest in manifests)
    print(f"\nBeside its training a cell takes {first - training:.2f} s, in a process that runs {warm:.2f} s")  # noqa: T201
    assert not is_timed or warm <= OVERHEAD
