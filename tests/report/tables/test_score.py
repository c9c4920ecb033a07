"""Every training under every ruler, as a terminal shows it."""

import pytest

from harness.registry import choose
from harness.report import FactsTable, score_facts
from harness.results.score_matrix import score_matrices
from tests.report.conftest import printed


@pytest.fixture
def matrix(build):
    """Baseline and arp, scored by each and by a third reward."""
    results = build()
    scoring = [choose(results.registry, "rewards", name) for name in ("baseline", "arp", "dense")]
    (matrix,) = score_matrices(results, scoring, results.registry)
    return matrix


@pytest.mark.parametrize("width", [60, 80])
def test_each_index_has_a_table(matrix, width):
    """Below what the cells share: a row per scoring reward, a column per training; sums with one decimal."""
    text = printed(FactsTable(score_facts([matrix])), width)
    assert text.startswith("mujoco · sac · fd100 · fd100-reach\n")
    rows = [line.split() for line in text.splitlines()]
    assert sum(row[-2:] == ["baseline", "arp"] for row in rows) == 2
    expected = [
        [scoring, *(f"{getattr(index, name):,.1f}" for index in of.values())]
        for name in ("I_N", "I_P")
        for scoring, of in matrix.indices.items()
    ]
    assert [of[0] for of in expected] == ["baseline", "arp", "dense"] * 2
    assert [row for row in rows if row and row[0] in matrix.indices] == expected
    assert text.index("I_N") < text.index("I_P")
