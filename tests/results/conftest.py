"""A small experiment, made by hand."""

from collections.abc import Callable
from pathlib import Path

import pytest

from harness.experiment.plan import Plan
from harness.record.cell import Cell
from harness.record.store import Store
from harness.record.terms import Terms
from harness.registry.registry import Registry, load_registry
from tests.results.folders import ARP, ARP_RUNS, BASELINE_RUNS, finish
from tests.results.in_looks import Folder, folder_in_looks


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


@pytest.fixture
def folder_of(
    make_cell: Callable[..., Cell], make_plan: Callable[..., Plan], registry: Registry, tmp_path: Path
) -> Callable[[Terms], Folder]:
    """An experiment that trains in looks, nothing done yet."""
    return lambda terms: folder_in_looks(terms, make_cell, make_plan, registry, tmp_path)
