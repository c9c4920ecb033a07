"""Small experiment folders, written without training anything."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pytest

from harness.cell import Cell
from harness.choice import Choice
from harness.manifest import Manifest, Status
from harness.plan import Plan
from harness.results import Results, load_results
from harness.run_cell import EVALUATION, RANDOM, TRACE
from harness.store import Store
from harness.trace import COLUMN, SCALARS, TraceWriter

BASELINE = "baseline"
ENVIRONMENT = {
    "versions": {"python": "3.11.7", "numpy": "2.4.0"},
    "machine": {"system": "Linux", "cpu": "a processor", "cpu_flags": ["avx", "fma"], "cores": 2},
    "commit": "0123456789abcdef",
    "command": "harness run --sim mujoco --algo sac",
    "sources": {"rewards": "f" * 64},
}

Build: TypeAlias = Callable[..., Results]
Rewards: TypeAlias = Callable[[int], np.ndarray]


@pytest.fixture
def build(tmp_path_factory: pytest.TempPathFactory) -> Build:
    """Writes a new experiment's folder and opens it; see `build_results`."""
    return lambda **given: build_results(tmp_path_factory.mktemp("experiment"), **given)


def dip_and_climb(seed: int) -> np.ndarray:
    """Rewards whose mean running sum over seeds 0 to 2 is negative from step 1 to step 17, then positive, (steps,)."""
    reward = np.full(40, 1.0 + 0.1 * seed)
    reward[0], reward[1:10] = 0.0, -1.0
    return reward


def build_results(
    folder: Path,
    *,
    baseline: Rewards = dip_and_climb,
    proposed: Mapping[str, Rewards] = {"arp": dip_and_climb},
    seeds: int = 3,
    simulators: tuple[str, ...] = ("mujoco",),
    ended: Mapping[tuple[str, int], tuple[Status, str]] = {},
    environment: dict[str, Any] = ENVIRONMENT,
) -> Results:
    """An experiment of `seeds` runs per reward.

    Args:
        folder: To write.
        baseline: The step rewards that the baseline paid, by seed.
        proposed: The same for each proposed reward, by label.
        seeds: How many.
        simulators: Labels.
        ended: How the cell of a (reward, seed) ended, with the reason, where it is not done.
        environment: Of every cell that ran.
    """
    rewards = {BASELINE: baseline, **proposed}
    cells = [_cell(sim, reward, seed) for seed in range(seeds) for sim in simulators for reward in rewards]
    store = Store.create(folder, Plan(BASELINE, tuple(cells), (), {"seeds": seeds}))
    for cell in cells:
        status, reason = ended.get((cell.reward.label, cell.seed), ("done", ""))
        if status == "done":
            _write_done(store, cell, rewards[cell.reward.label](cell.seed), environment)
        elif status != "pending":
            store.record(cell, status, reason)
    return load_results(folder)


def _cell(simulator: str, reward: str, seed: int) -> Cell:
    sim, task, algorithm, paid = (Choice(name, (), name) for name in (simulator, "fd100-reach", "sac", reward))
    return Cell(sim, "fd100", task, algorithm, paid, seed, 40, 4)


def _write_done(store: Store, cell: Cell, reward: np.ndarray, environment: dict[str, Any]) -> None:
    folder = store.cell_folder(cell)
    folder.mkdir(parents=True)
    _write_trace(folder / TRACE, reward=reward)
    _write_trace(folder / EVALUATION, reached=[1, 1, 1, 0], truncated=[0, 0, 0, 1], step=[8, 9, 10, 100], distance=0.04)
    _write_trace(folder / RANDOM, ground=[1, 1, 1, 1], step=[20, 30, 40, 50], distance=0.9)
    Manifest(cell, "done", started="2026-01-01T00:00:00+00:00", seconds=12.5, environment=environment).write(folder)


def _write_trace(path: Path, **columns: Any) -> None:
    """A trace with these columns; the others are 0."""
    rows = np.zeros((max(np.size(values) for values in columns.values()), len(SCALARS) + 2))
    for name, values in columns.items():
        rows[:, COLUMN[name]] = values
    with TraceWriter(path, dof=1, action_size=1) as writer:
        writer.append(rows)
