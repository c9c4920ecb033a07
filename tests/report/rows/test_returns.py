"""Returns under every reward, as text."""

from harness.report import return_grid


def _matrix(results):
    (matrix,) = results.returns
    return matrix


def test_grid_has_a_row_per_ruler_and_the_events(build):
    """Each with its interval below; a column per training."""
    grid = return_grid(_matrix(build()))
    assert grid.headings == ("evaluation return, scored by", "baseline", "arp")
    names = [row[0] for row in grid.rows]
    assert names == ["baseline", "  95% interval", "arp", "  95% interval", "events, paid on top", "  95% interval"]
    assert all(len(row) == 3 for row in grid.rows)


def test_one_seed_has_no_rows_of_intervals(build):
    """And a note says why."""
    grid = return_grid(_matrix(build(seeds=1)))
    assert [row[0] for row in grid.rows] == ["baseline", "arp", "events, paid on top"]
    assert grid.notes == ["one seed: no interval below 3 seeds"]


def test_reward_that_cannot_score_is_na_with_the_reason(build):
    """Its row says n/a, a note says why; the others are scored."""
    grid = return_grid(_matrix(build(proposed={"gone": (9, 30)})))
    rows = {row[0]: row[1:] for row in grid.rows}
    assert rows["gone"] == ("n/a", "n/a")
    assert "n/a" not in rows["baseline"]
    assert any(note.startswith("gone: n/a: No reward 'gone'") for note in grid.notes)
