"""What a matrix costs beside its trainings: two jobs against one, and a cell's time that is no training."""

import statistics
import time

import pytest

from harness import load_registry
from harness.executor import CellOptions, Job, run_jobs
from harness.experiment.plan import check_experiment, expand
from harness.record import read_manifest
from tests.bench.timings.conftest import cpu_seconds

pytestmark = pytest.mark.bench

CELLS, STEPS = 4, 2000
AT_ONCE, KEPT, TRAINING = 1.5, 0.8, 0.6
"""Cells that two jobs do at once; CPU time of one job against two; the share of a cell that is its training."""


@pytest.fixture
def cells(amount):
    """Trainings of `sac-fast` with an evaluation of 100 episodes each; next to nothing where no bound holds."""
    asked = {"sim": "mujoco", "algo": "sac-fast", "reward": [], "seeds": amount(CELLS, 2), "steps": amount(STEPS, 20)}
    return expand(check_experiment({**asked, "evaluation_episodes": amount(100, 2)}), load_registry()).cells


def _run(cells, folder, at_once):
    jobs = [Job(cell, folder / cell.id, CellOptions(floor=number == 0)) for number, cell in enumerate(cells)]
    run_jobs(jobs, at_once, lambda event: None)
    manifests = [read_manifest(folder / cell.id) for cell in cells]
    assert {manifest.status for manifest in manifests} == {"done"}
    return manifests


def test_two_jobs_beside_one(cells, tmp_path, require_ratio):
    """Both are at work nearly all of the time, and waste nothing of it. Processes that start are counted."""
    took = [cpu_seconds(lambda at_once=n: _run(cells, tmp_path / str(at_once), at_once)) for n in (1, 2)]
    began = time.perf_counter()
    both = _run(cells, tmp_path / "again", 2)
    whole = time.perf_counter() - began
    require_ratio(took[0] / took[1], KEPT, f"(CPU: one {took[0]:.1f} s, two {took[1]:.1f} s)", "CPU time")
    require_ratio(sum(manifest.seconds for manifest in both) / whole, AT_ONCE, f"({whole:.1f} s)", "at once")


def test_a_cell_is_mostly_its_training(cells, tmp_path, require_ratio):
    """The median of those that follow the first one, which starts the process."""
    shares = [manifest.training_seconds / manifest.seconds for manifest in _run(cells, tmp_path / "all", 1)[1:]]
    require_ratio(statistics.median(shares), TRAINING)
