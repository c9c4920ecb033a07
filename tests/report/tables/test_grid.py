"""A grid in windows of every width."""

from dataclasses import replace

from rich.console import Group

from harness.report.tables.grid import show_grid
from harness.results import Grid
from tests.report import conftest

GRID = Grid(
    ("measure of behaviour", "baseline", "proposed", "difference", "random"),
    [("closest distance [m]", *["0.123456789"] * 4), ("  95% interval", *["[-0.5, 0.5]"] * 4)],
    ["a note"],
)


def printed(grid, *console, **given):
    """What goes to a terminal."""
    return conftest.printed(Group(*show_grid(grid)), *console, **given)


def test_columns_stand_in_as_few_tables_as_fit(subtests):
    """Names take 14 characters at least, and a value 11 and a gap of 2."""
    for width, tables in [(100, 1), (66, 1), (65, 2), (40, 2), (39, 4), (20, 4)]:
        with subtests.test(width=width, tables=tables):
            assert printed(GRID, width).count("closest") == tables


def test_tables_are_of_about_the_same_size():
    """Every column stands in one of them, in order."""
    five = Grid(("name", *"abcde"), [("x", *["0123456789"] * 5)], [])
    headings = [line.split()[1:] for line in printed(five, 45).splitlines() if line.startswith("name")]
    assert headings == [["a", "b"], ["c", "d", "e"]]


def test_every_value_and_every_word_is_whole(subtests):
    """However narrow the window is, and no line is longer than it."""
    for width in range(24, 120, 5):
        with subtests.test(width=width):
            text = printed(GRID, width)
            assert text.count("0.123456789") == text.count("[-0.5, 0.5]") == 4
            tables = text.count("closest")
            for word in ("behaviour", "closest", "distance", "95%", "interval"):
                assert text.count(word) == tables
            assert max(map(len, text.splitlines())) <= width


def test_value_wider_than_the_window_is_folded():
    """Nothing of it is lost."""
    label = "sac-fast:gamma=0.9,net_arch=8x8,learning_starts=50"
    text = printed(Grid(("", label), [("arp", "1.0")], []), 40)
    assert label in "".join(text.split())
    assert "…" not in text


def test_markup_is_text():
    """Names, values and notes may hold brackets."""
    text = printed(Grid(("name [m]", "[b]"), [("x [report]", "[i]")], ["pip install 'a[report]'"]), 60)
    for part in ("name [m]", "[b]", "x [report]", "[i]", "pip install 'a[report]'"):
        assert part in text


def test_notes_come_once():
    """Under the last table."""
    assert printed(GRID, 40).count("a note") == 1
    assert printed(GRID, 40).endswith("a note\n")


def test_empty_grid_is_nothing():
    """Not even an empty line."""
    assert show_grid(Grid(("name", "value"), [], [])) == []


def test_title_stands_above_its_rows():
    """Whole and once, also where the table is divided; without rows there is none."""
    titled = replace(GRID, title="Behaviour of the trained policies")
    for width in (40, 100):
        text = printed(titled, width).strip()
        assert text.startswith("Behaviour of the trained policies\n")
        assert text.count("Behaviour of") == 1
    assert printed(replace(titled, rows=[]), 100).strip() == "a note"
