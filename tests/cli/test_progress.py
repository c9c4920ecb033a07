import io

import pytest
from rich.console import Console

from harness.cli.progress import LiveProgress
from harness.executor import Event
from harness.record.cell import Cell


@pytest.fixture
def terminal():
    """A terminal that keeps what it shows."""
    return Console(file=io.StringIO(), force_terminal=True, width=120)


@pytest.fixture
def pipe():
    """No terminal."""
    return Console(file=io.StringIO(), width=120)


def play(progress, cell, reason=""):
    """A cell from its start to its end."""
    progress(Event("started", cell))
    progress(Event("progress", cell, steps=6))
    progress(Event("ended", cell, reason=reason))


def test_a_running_cell_has_a_bar_and_so_have_all_cells(make_cell, terminal):
    """On a terminal each running cell shows its steps, and one bar stands for all."""
    cell = make_cell()
    with LiveProgress([cell], [], terminal) as progress:
        progress(Event("started", cell))
        progress(Event("progress", cell, steps=6))
    shown = terminal.file.getvalue()
    assert cell.title in shown
    assert "all cells" in shown
    assert "6/12" in shown


def test_without_a_terminal_lines_are_printed(make_cell, pipe):
    """In a log a cell has a line when it starts and one when it ends, and nothing moves."""
    cell = make_cell()
    with LiveProgress([cell], [], pipe) as progress:
        play(progress, cell)
    lines = pipe.file.getvalue().splitlines()
    assert lines[0] == f"{cell.title}: started"
    assert lines[1].startswith(f"[1/1] {cell.title}: ")
    assert len(lines) == 2


def test_a_failed_cell_says_why(make_cell, pipe):
    """The reason stands in the line that ends the cell."""
    cell = make_cell()
    with LiveProgress([cell], [], pipe) as progress:
        play(progress, cell, reason="RuntimeError: the [arm] fell off")
    assert "FAILED: RuntimeError: the [arm] fell off" in pipe.file.getvalue()


def test_cells_that_were_done_are_counted(make_cell, pipe):
    """What is not run again is told, and the count goes on from there."""
    done, cell = make_cell(seed=0), make_cell(seed=1)
    with LiveProgress([done, cell], [done], pipe) as progress:
        play(progress, cell)
    assert "1 of 2 cells were done before" in pipe.file.getvalue()
    assert "[2/2]" in pipe.file.getvalue()


def test_many_cells_begin_quickly(make_cell, pipe, monkeypatch):
    """Each cell is hashed a few times at most, however many there are: that is slow."""
    hashed = 0
    plain = Cell.__hash__

    def count(cell):
        nonlocal hashed
        hashed += 1
        return plain(cell)

    monkeypatch.setattr(Cell, "__hash__", count)
    cells = [make_cell(seed=seed) for seed in range(200)]
    LiveProgress(cells, cells[:100], pipe)
    assert hashed <= 2 * len(cells)


def test_a_cell_has_one_line_at_80_columns(make_cell):
    """Name, bar, steps, speed and the time left."""
    terminal = Console(file=io.StringIO(), force_terminal=True, width=80, color_system=None)
    cell = make_cell()
    with LiveProgress([cell], [], terminal) as progress:
        progress(Event("started", cell))
        progress(Event("progress", cell, steps=6))
    last = terminal.file.getvalue().split("\r")[-1].split("\n")
    (line,) = [line for line in last if cell.title in line]
    assert "6/12 · " in line
    assert "-:--:--" in line
