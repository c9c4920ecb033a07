"""Random actions are evaluated by one cell for all that share simulator, task and robot."""

import pytest

from harness.record import RANDOM
from harness.record.store import floors_in
from harness.registry import Choice
from tests.results.folders import ARP

SLOWER = Choice("fd100-reach", (("horizon", 6),), "fd100-reach:horizon=6")


@pytest.fixture
def run(make_plan, run_here, tmp_path):
    """Run these cells, in one folder."""
    return lambda *cells: run_here(make_plan(*cells), tmp_path / "out")


def _with_floor(results):
    """Cells of the plan that evaluated random actions."""
    return [cell for cell in results.plan.cells if (results.store.cell_folder(cell) / RANDOM).is_file()]


def test_the_first_cell_does_it_for_all(make_cell, run):
    """Of each task one; rewards and seeds share."""
    cells = [make_cell(seed=seed, reward=reward) for seed in range(2) for reward in (make_cell().reward, ARP)]
    other = make_cell(task=SLOWER)
    results = run(*cells, other)
    assert _with_floor(results) == [cells[0], other]
    assert floors_in(results.manifests, results.store) == {cells[0].floor: cells[0], other.floor: other}


def test_every_cell_is_held_against_it(make_cell, run):
    """What random actions do is told beside each policy."""
    cells = [make_cell(seed=seed) for seed in range(3)]
    results = run(*cells)
    values = [results.measured(cell).random for cell in cells]
    assert values[0]["final_distance"] is not None
    assert values[0] == values[1] == values[2]


def test_a_floor_that_is_there_is_not_made_again(make_cell, run):
    """A later run adds seeds."""
    first, second = make_cell(), make_cell(seed=1)
    run(first)
    assert _with_floor(run(first, second)) == [first]


def test_a_floor_that_was_lost_is_made_again(make_cell, run):
    """The cell that had it is damaged: the next run does it again, floor and all."""
    first, second = make_cell(), make_cell(seed=1)
    results = run(first, second)
    (results.store.cell_folder(first) / RANDOM).unlink()
    assert results.store.examine(first).status == "damaged"
    assert _with_floor(run(first, second)) == [first]


def test_without_a_floor_nothing_is_said_of_random_actions(make_cell, run):
    """The cell that was to do them failed."""
    breaks = Choice("wander", (("then", "raise"),), "wander:then=raise")
    cells = [make_cell(algorithm=breaks), make_cell(seed=1)]
    results = run(*cells)
    assert set(results.measured(cells[1]).random.values()) == {None}
    assert results.store.examine(cells[1]).status == "done"
