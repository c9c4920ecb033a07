from dataclasses import dataclass
from types import SimpleNamespace

import pytest

from harness.eta import SeedMean, mean_over_seeds
from harness.registry import Choice
from harness.results.comparison import Group
from harness_plugins.transfer.matrix import TransferMatrix
from harness_plugins.transfer.shown import failure_lines, transfer_block, transfer_grid

NAMES = ("ideal", "mujoco", "stuck", "gone", "far")


def choice(name):
    """A choice without parameters."""
    return Choice(name, (), name)


def matrix_of(rows, drops, homes=("ideal",)):
    """A matrix of these means; returns are ten times the success."""
    places = NAMES[: len(rows[0])]
    group = Group("fd100", choice("fd100-reach"), choice("sac"), 100, 10, reward=choice("arp"))
    paid = tuple(tuple(SeedMean(mean.mean and 10 * mean.mean, None, None, mean.seeds) for mean in row) for row in rows)
    return TransferMatrix(group, homes, places, rows, paid, drops)


@pytest.fixture
def matrix():
    """Ideal's policies: 75 % at home, 25 % in mujoco, nothing recorded of stuck."""
    success = (mean_over_seeds([0.7, 0.75, 0.8]), mean_over_seeds([0.2, 0.3]), mean_over_seeds([], "2 of 2 failed"))
    drop = (SeedMean(None), mean_over_seeds([0.5, 0.5, 0.5]), mean_over_seeds([], "2 of 2 failed"))
    return matrix_of((success,), (drop,))


def test_cells_have_value_interval_and_drop(matrix):
    """At home there is no drop; where nothing is recorded there is n/a and nothing else."""
    (row,) = transfer_block(matrix).rows
    home, away, missing = row.cells
    assert (home.success, home.success_interval, home.drop, home.home) == ("75.0%", "[62.6, 87.4]", "", True)
    assert (away.success, away.drop, away.drop_interval, away.home) == ("25.0%", "50.0 pp", "[50.0, 50.0]", False)
    assert (away.paid, away.share) == ("2.50", 0.25)
    assert (missing.success, missing.success_interval, missing.drop, missing.paid) == ("n/a", "", "", "n/a")


def test_largest_drop_is_in_words(matrix):
    """With the simulator and the interval."""
    assert transfer_block(matrix).summary == (
        "Trained in ideal: the largest drop of success is 50.0 pp [50.0, 50.0], in mujoco.",
    )


def test_nothing_known_elsewhere_is_said():
    """A row with its home alone has no drop to name."""
    row, drop = (mean_over_seeds([0.5]), mean_over_seeds([], "1 of 1 failed")), (SeedMean(None), SeedMean(None))
    assert transfer_block(matrix_of((row,), (drop,))).summary == ("Trained in ideal: not evaluated anywhere else.",)


def test_notes_say_where_they_hold(matrix):
    """What is so everywhere stands without a place."""
    assert transfer_block(matrix).notes == (
        "ideal in mujoco: 2 seeds: no interval below 3 seeds",
        "ideal in stuck: 2 of 2 failed",
    )
    everywhere = matrix_of(((mean_over_seeds([0.5]),),), ((SeedMean(None),),))
    assert transfer_block(everywhere).notes == ("one seed: no interval below 3 seeds",)


def test_no_minus_zero():
    """A drop that rounds to nothing has no sign."""
    row = (mean_over_seeds([0.5]), mean_over_seeds([0.5]))
    (line,) = transfer_block(matrix_of((row,), ((SeedMean(None), SeedMean(-1e-9, seeds=1)),))).rows
    assert line.cells[1].drop == "0.0 pp"


def test_terminal_has_a_line_for_each_thing(matrix):
    """Success first, the home marked, each interval under its mean; lines without a value are left out."""
    grid = transfer_grid(transfer_block(matrix))
    assert grid.headings == ("trained in \\ evaluated in", "ideal", "mujoco", "stuck")
    assert [row[0].strip() for row in grid.rows] == [
        "ideal: success", "95% interval", "drop", "95% interval", "return",
    ]  # fmt: skip
    assert [value.strip() for value in grid.rows[0][1:]] == ["75.0% *", "25.0%", "n/a"]


def test_words_stand_under_the_table(matrix):
    """The largest drops, then what is to be kept in mind."""
    block = transfer_block(matrix)
    assert transfer_grid(block).notes == [*block.summary, *block.notes]


def test_failure_names_cell_simulator_and_reason():
    """One line."""

    @dataclass
    class Title:
        title: str

    record = SimpleNamespace(simulator=choice("stuck"), status="failed", reason="RuntimeError: it fell")
    assert failure_lines([(Title("ideal · sac · arp · seed 0"), record)]) == [
        "failed: ideal · sac · arp · seed 0 in stuck: RuntimeError: it fell"
    ]
