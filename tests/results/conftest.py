"""A small experiment, made by hand."""

from collections.abc import Callable
from pathlib import Path

import pytest

from harness.experiment.plan import Plan
from harness.record.cell import Cell
from harness.record.store import Store
from harness.registry.registry import Registry, load_registry
from tests.results.folders import ARP, ARP_RUNS, BASELINE_RUNS, finish


@pytest.fixture(scope="module")
def registry() -> Registry:
    """The installed plugins, their metrics above all."""
    return load_registry()


@pytest.fixture
def experiment(make_cell: Callable[..., Cell], make_plan: Callable[..., Plan], tmp_path: Path) -> Store:
    """Three seeds of both rewards, all done."""
    cells = [make_cell(seed=seed, reward=reward) for seed in range(3) for reward in (make_cell().reward, ARP)]
    store = Store.create(tmp_path, make_plan(*cells))
    for cell in cells:
        finish(store, cell, (ARP_RUNS if cell.reward == ARP else BASELINE_RUNS)[cell.seed])
    return store
