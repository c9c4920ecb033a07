"""The map of answers and the table."""

from harness.report.facts import overview_grids
from harness.report.page.answer import matrix_of


def test_map_has_a_row_per_reward_and_a_column_per_place(build):
    """What is the same in all is said once."""
    results = build(seeds=1, simulators=("mujoco", "pybullet"), proposed={"arp": (9, 30), "relative": (9, 30)})
    matrix = matrix_of(results.combinations)
    assert matrix.places == ["mujoco", "pybullet"]
    assert [(reward, [entry.place for entry in entries]) for reward, entries in matrix.rows] == [
        ("arp", ["mujoco", "pybullet"]),
        ("relative", ["mujoco", "pybullet"]),
    ]


def test_entries_lead_to_their_comparison(build):
    """In the order of the page."""
    matrix = matrix_of(build(seeds=1, simulators=("mujoco", "pybullet")).combinations)
    assert [entry.anchor for entry in matrix.entries] == ["combination-1", "combination-2"]


def test_answer_is_a_symbol_and_a_count(build):
    """Told apart without colour."""
    matrix = matrix_of(build().combinations)
    assert [(entry.symbol, entry.difference) for entry in matrix.entries] == [("?", "+0.0")]
    assert matrix.counts == [("cannot-tell", "CANNOT TELL", 1)]


def test_null_control_is_marked(build):
    """It is no reward of its own."""
    assert [reward for reward, _ in matrix_of(build(a_a=True).combinations).rows] == ["arp", "baseline (A/A)"]


def test_the_table_is_that_of_the_terminal(build):
    """Line by line, with intervals."""
    results = build(simulators=("mujoco", "pybullet"))
    (grid,) = overview_grids(results.combinations, with_intervals=True)
    table = matrix_of(results.combinations).table
    assert (table.headings, table.rows) == (grid.headings, grid.rows)


def test_nothing_compared_is_an_empty_map():
    """As of an experiment whose combinations were all skipped."""
    matrix = matrix_of([])
    assert (matrix.places, matrix.rows, matrix.entries) == ([], [], [])
