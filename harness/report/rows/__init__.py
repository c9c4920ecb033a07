"""What a report says, as text: what the terminal, the page and the summary share."""

from typing import NamedTuple


class Grid(NamedTuple):
    """A small table, ready to print: a name in the first column, then values; notes below."""

    headings: tuple[str, ...]
    rows: list[tuple[str, ...]]
    notes: list[str]
    title: str = ""
    """The title above the grid. As the heading of the names it would wrap."""
