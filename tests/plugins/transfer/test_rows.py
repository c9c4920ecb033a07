from dataclasses import dataclass
from types import SimpleNamespace

import pytest

from harness.eta import Estimate, mean_over_seeds
from harness.registry import Choice
from harness.results import Group
from harness_plugins.transfer.matrix import TransferMatrix, Transfers
from harness_plugins.transfer.shown import transfer_facts, transfer_grid

NAMES = ("ideal", "mujoco", "stuck", "gone", "far")


def choice(name):
    """A choice without parameters."""
    return Choice(name, (), name)


def matrix_of(rows, drops, homes=("ideal",)):
    """A matrix of these means; returns are ten times the success."""
    places = NAMES[: len(rows[0])]
    group = Group("fd100", choice("fd100-reach"), choice("sac"), 100, 10, reward=choice("arp"))
    paid = tuple(
        tuple(Estimate(mean.value and 10 * mean.value, None, None, mean.seeds) for mean in row) for row in rows
    )
    return TransferMatrix(group, homes, places, rows, paid, drops)


@pytest.fixture
def matrix():
    """Ideal's policies: 75 % at home, 25 % in mujoco, nothing recorded of stuck."""
    success = (mean_over_seeds([0.7, 0.75, 0.8]), mean_over_seeds([0.2, 0.3]), mean_over_seeds([], "2 of 2 failed"))
    drop = (Estimate(None), mean_over_seeds([0.5, 0.5, 0.5]), mean_over_seeds([], "2 of 2 failed"))
    return matrix_of((success,), (drop,))


def cells_of(grid):
    """The rows of a table by their names; the rows of intervals by that above them."""
    found, above = {}, ""
    for name, *values in grid.rows:
        above = above if name == "  95% interval" else name.strip()
        found[f"{above}, interval" if name == "  95% interval" else above] = values
    return found


def test_a_place_has_value_interval_and_drop(matrix):
    """At home there is no drop; where nothing is recorded there is n/a and nothing else."""
    grid = transfer_grid(matrix)
    assert grid.headings == ("trained in \\ evaluated in", "ideal", "mujoco", "stuck")
    assert cells_of(grid) == {
        "ideal: success": ["75.0%", "25.0%", "n/a"],
        "ideal: success, interval": ["[62.6%, 87.4%]", "", ""],
        "drop": ["", "50.0", ""],
        "drop, interval": ["", "[50.0, 50.0]", ""],
        "return": ["7.50", "2.50", "n/a"],
    }


def test_largest_drop_is_in_words(matrix):
    """With the simulator and the interval; below it what is to be kept in mind, and where it holds."""
    assert transfer_grid(matrix).notes == [
        "Trained in ideal: the largest drop of success is 50.0 [50.0, 50.0] points, in mujoco.",
        "ideal in mujoco: 2 seeds: no interval below 3 seeds",
        "ideal in stuck: 2 of 2 failed",
    ]


def test_nothing_known_elsewhere_is_said():
    """A row with its home alone has no drop to name."""
    row, drop = (mean_over_seeds([0.5]), mean_over_seeds([], "1 of 1 failed")), (Estimate(None), Estimate(None))
    told, *_ = transfer_grid(matrix_of((row,), (drop,))).notes
    assert told == "Trained in ideal: not evaluated anywhere else."


def test_what_is_so_everywhere_stands_without_a_place():
    """One seed in the only place."""
    everywhere = matrix_of(((mean_over_seeds([0.5]),),), ((Estimate(None),),))
    assert transfer_grid(everywhere).notes[1:] == ["one seed: no interval below 3 seeds"]


def test_no_minus_zero():
    """A drop that rounds to nothing has no sign."""
    row = (mean_over_seeds([0.5]), mean_over_seeds([0.5]))
    grid = transfer_grid(matrix_of((row,), ((Estimate(None), Estimate(-1e-9, seeds=1)),)))
    assert cells_of(grid)["drop"] == ["", "0.0"]


def test_failure_names_cell_simulator_and_reason():
    """One line, behind the tables."""

    @dataclass
    class Title:
        title: str

    record = SimpleNamespace(simulator=choice("stuck"), status="failed", reason="RuntimeError: it fell")
    facts = transfer_facts(Transfers((), ((Title("ideal · sac · arp · seed 0"), record),)))
    assert facts[-1].lines == ("failed: ideal · sac · arp · seed 0 in stuck: RuntimeError: it fell",)
