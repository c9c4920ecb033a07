"""Tables on the terminal."""

from dataclasses import replace
from io import StringIO

import pytest
from rich.console import Group
from rich.table import Table
from rich.text import Text

from harness.cli.progress import LiveProgress
from harness.executor import Event
from harness.report.tables.grid import Terminal, show

EVIL = "\x1b]0;title\x07[/b]\u202e"


def table():
    """A table that names something in a heading, and in a row."""
    made = Table()
    made.add_column(Text(EVIL), overflow="fold")
    made.add_row(Text(EVIL))
    return made


@pytest.mark.parametrize("renderable", [Text(EVIL), Group(Text(EVIL)), table()], ids=["text", "group", "table"])
def test_a_label_is_shown_and_obeyed_by_nothing(renderable):
    """Neither as a command of the terminal nor as markup."""
    terminal = Terminal(file=StringIO(), width=100, force_terminal=True)
    with terminal.capture() as capture:
        terminal.print(renderable)
    shown = capture.get()
    assert "\\x1b]0;title" in shown
    assert "[/b]" in shown
    assert "\x1b]" not in shown
    assert "\u202e" not in shown


def test_colours_of_our_own_stay():
    """The terminal still gets what makes a title bold."""
    terminal = Terminal(file=StringIO(), force_terminal=True, color_system="standard", no_color=False)
    with terminal.capture() as capture:
        terminal.print(Text("title", style="bold"))
    assert "\x1b[1mtitle" in capture.get()


def test_a_bar_shows_a_title_as_it_is(make_cell):
    """A label is no markup there."""
    output, made = StringIO(), make_cell()
    cell = replace(made, simulator=replace(made.simulator, label="a[/b]c"))
    with LiveProgress([cell], [], Terminal(file=output, force_terminal=True, width=200)) as progress:
        progress(Event("started", cell))
        progress(Event("progress", cell, steps=1))
    assert "a[/b]c" in output.getvalue()


@pytest.mark.parametrize(("columns", "widest"), [("240", 100), ("60", 60)])
def test_no_line_is_longer_than_100_characters(monkeypatch, capsys, columns, widest):
    """However wide the window is; a narrow one stays as it is."""
    monkeypatch.setenv("COLUMNS", columns)
    show(Text("word " * 100))
    assert max(map(len, capsys.readouterr().out.splitlines())) in range(widest - 5, widest + 1)
