"""Every training under every ruler, as a terminal shows it."""

from io import StringIO

import pytest
from rich.console import Console

from harness.registry import choose
from harness.report import score_table
from harness.report.tables.score import score_grids
from harness.results import score_matrices


@pytest.fixture
def matrix(build):
    """Baseline and arp, scored by each and by a third reward."""
    results = build()
    scoring = [choose(results.registry, "rewards", name) for name in ("baseline", "arp", "dense")]
    (matrix,) = score_matrices(results, scoring, results.registry)
    return matrix


def test_each_index_has_a_grid(matrix):
    """A row per scoring reward, a column per training; the sums with one decimal, as published."""
    for name, grid in zip(("I_N", "I_P"), score_grids(matrix), strict=True):
        assert name in grid.headings[0]
        assert grid.headings[1:] == ("baseline", "arp")
        assert [row[0] for row in grid.rows] == ["baseline", "arp", "dense"]
        for scoring, *values in grid.rows:
            indices = matrix.indices[scoring].values()
            assert values == [f"{getattr(index, name):,.1f}" for index in indices]


@pytest.mark.parametrize("width", [60, 80])
def test_terminal_has_every_number_whole(matrix, width):
    """Below what the cells share."""
    output = StringIO()
    Console(file=output, width=width).print(score_table([matrix]))
    text = output.getvalue()
    assert text.startswith("mujoco · sac · fd100 · fd100-reach\n")
    assert all(value in text for grid in score_grids(matrix) for row in grid.rows for value in row)
