"""A bench as a terminal shows it."""

from dataclasses import replace

import pytest
from rich.console import Console

from harness_plugins.bench.cells import HEADINGS, Bench, bench_table, time_grid
from harness_plugins.bench.stopwatch import PARTS


@pytest.fixture
def rows(make_timing):
    """Of a training of 8 of 10 seconds, 1,000 steps, by the name of the part."""
    return {name: cells for name, *cells in time_grid(make_timing()).rows}


def test_every_part_has_a_row_and_so_have_the_sums(rows):
    """In the order of the parts; as many columns as headings."""
    assert len(rows) == len(PARTS) + 2
    assert list(rows)[-2:] == ["training", "whole"]
    assert all(len(cells) == len(HEADINGS) - 1 for cells in rows.values())


def test_rows_have_seconds_share_and_microseconds_per_step(rows):
    """Of 10 s the algorithm took 4.5 in 1,000 steps."""
    assert rows["algorithm"] == ["4.500", "45.0%", "4,500.0"]


def test_what_does_not_grow_with_the_steps_has_no_time_per_step(rows):
    """A start takes as long for ten steps as for a million."""
    assert rows["start-up"] == ["1.000", "10.0%", ""]
    assert rows["whole"] == ["10.000", "100.0%", ""]


def test_shares_add_up(rows):
    """The parts' to the whole."""
    shares = [float(cells[1].rstrip("%")) for name, cells in rows.items() if name not in ("training", "whole")]
    assert sum(shares) == pytest.approx(100.0)


def test_notes_tell_speed_and_price(make_timing):
    """Steps per second of training, and what the timing added to each."""
    notes = " ".join(time_grid(make_timing(clock_seconds=5e-7)).notes)
    assert "125 environment steps per second" in notes
    assert "some 2.0 us of each step" in notes


def test_a_busy_machine_is_told(make_timing, make_times):
    """Where the process had to wait for a core, and only there."""
    timing = make_timing()
    waiting = replace(timing, rounds=(replace(make_times(), core_share=0.4),))
    assert "a core for 40% of the time" in " ".join(time_grid(waiting).notes)
    assert "a core for" not in " ".join(time_grid(timing).notes)


def test_table_names_the_combination_and_what_did_not_work(make_timing, make_cell):
    """The reason beside it, brackets and all."""
    bench = Bench(
        3, (make_timing({}, {}, {}),), ((make_cell(), "no [m] left"),), ((make_cell(), "it cannot"),), "a cpu", {}
    )
    console = Console(width=100)
    with console.capture() as capture:
        console.print(bench_table(bench))
    text = capture.get()
    assert "ideal · wander · baseline · fd100 · fd100-reach:horizon=5" in text
    assert "1,000 environment steps, medians of 3 rounds" in text
    assert "failed: ideal · wander · baseline · seed 0: no [m] left" in text
    assert "skipped: ideal · wander · baseline · seed 0: it cannot" in text
