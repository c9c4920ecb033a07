"""Speeds as a terminal and as a page show them."""

import pytest
from rich.console import Console

from harness.report.figures.chart import Dots
from harness_plugins.bench.speeds import compare_speeds
from harness_plugins.bench.tables import comparison_grid, draw_speeds, speed_grids, speed_table, write_speed_page


@pytest.fixture
def slower(make_speeds):
    """A run of two simulators of which the second became slower, and what the earlier run says of it."""
    new = make_speeds(
        [0.8, 0.81, 0.79], [0.4, 0.41, 0.39], failed=(("bad <arm>", "it broke"),), left_out=(("far", "no [m]"),)
    )
    return new, compare_speeds(make_speeds([0.8, 0.81, 0.79], [0.8, 0.81, 0.79]), new)


def test_a_line_has_both_times_the_ratio_and_its_spread(make_speeds):
    """Half the speed of 100 us is 200 us."""
    [grid] = speed_grids(make_speeds([0.4, 0.5, 0.6]))
    assert grid.rows == [("sim-0, 1 env: env", "200.0", "bare engine", "100.0", "0.50", "0.45 to 0.55")]
    assert len(grid.headings) == len(grid.rows[0])


def test_nothing_measured_is_no_grid(make_speeds):
    """Neither headings nor notes."""
    assert speed_grids(make_speeds()) == []


def test_a_comparison_says_of_every_line_what_changed(slower):
    """In words that the terminal colours."""
    rows = {name: values for name, *values in comparison_grid(slower[1]).rows}
    assert rows["sim-0, 1 env: env"][:3] == ["0.80", "0.80", "+0.0%"]
    assert [values[-1] for values in rows.values()] == ["same", "SLOWER"]


def test_the_terminal_ends_with_what_became_slower(slower):
    """After the numbers, and what has none."""
    console = Console(width=120)
    with console.capture() as capture:
        console.print(speed_table(*slower))
    text = capture.get()
    assert "failed: bad <arm>: it broke" in text
    assert "left out: far: no [m]" in text
    assert text.rstrip().splitlines()[-1].startswith("SLOWER  sim-1, 1 env: env is 50% slower beside the bare engine")


def test_the_page_has_figure_tables_and_verdict(slower, tmp_path):
    """One file; names are text, whatever they hold."""
    write_speed_page(*slower, tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    for text in ("SLOWER  sim-1, 1 env: env is 50% slower", "<svg", "speed before", "bad &lt;arm&gt;: it broke"):
        assert text in page
    assert "<script" not in page


def test_the_figure_has_a_row_for_each_line_now_and_before(slower):
    """The median of each as a dot; without an earlier run there are only those of now."""
    both, now = draw_speeds(*slower), draw_speeds(slower[0], None)
    assert [len(mark.x) for mark in both.marks if isinstance(mark, Dots)] == [2, 2]
    [dots] = [mark for mark in now.marks if isinstance(mark, Dots)]
    assert list(dots.x) == [0.8, 0.4]
    assert [name for _, name in now.y.ticks] == ["sim-0, 1 env: env", "sim-1, 1 env: env"]


def test_without_a_reference_there_is_no_figure(make_speeds, tmp_path):
    """And the page stands without one."""
    speeds = make_speeds()
    assert draw_speeds(speeds, None) is None
    write_speed_page(speeds, None, tmp_path / "page.html")
    assert "<svg" not in (tmp_path / "page.html").read_text()
