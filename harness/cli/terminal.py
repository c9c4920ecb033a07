"""Tables for the terminal: no label of a file is markup there, nor sends it a command."""

from collections.abc import Iterable

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.text import Text

from harness.text import visible

WIDEST = 100
"""Characters of a line: a wider window does not make longer ones."""


class Terminal(Console):
    """A console that shows hidden characters as escapes, whoever made the text; its own colours stay."""

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """Called by rich for whatever it prints, and for all that stands in it."""
        whole = _visible(renderable) if isinstance(renderable, Text) else renderable
        for text, style, control in super().render(whole, options):
            yield Segment(text if control else visible(text, keep="\n"), style, control)


def _visible(text: Text) -> Text:
    """Before it is broken into lines, which an escape makes longer."""
    shown = text.copy()
    shown.plain = visible(text.plain, keep="\n")
    return shown


def show(table: RenderableType, err: bool = False) -> None:
    """Print a table, on standard output or on standard error."""
    console = Terminal(stderr=err)
    console.width = min(console.width, WIDEST)
    console.print(table)
