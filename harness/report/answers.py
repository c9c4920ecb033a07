"""How each answer looks: its word, its symbol, its colour in a terminal, its class on a page."""

from typing import NamedTuple

from harness.eta.headline import Answer


class Look(NamedTuple):
    """How one answer looks."""

    symbol: str
    """Tells the answers apart without colour."""
    style: str = ""
    """The style of rich for the word in a terminal; empty for plain text."""


LOOKS = {
    Answer.HELPS: Look("▲", "bold green"),
    Answer.HURTS: Look("▼", "bold red"),
    Answer.LEARNS_FASTER: Look("»", "green"),
    Answer.LEARNS_SLOWER: Look("«", "red"),
    Answer.MIXED: Look("±", "bold magenta"),
    Answer.NO_DIFFERENCE: Look("="),
    Answer.NEITHER_LEARNS: Look("0"),
    Answer.AHEAD: Look("△", "cyan"),
    Answer.BEHIND: Look("▽", "cyan"),
    Answer.CANNOT_TELL: Look("?"),
    Answer.INTERIM: Look("…"),
}
STYLES = {answer.value.upper(): look.style for answer, look in LOOKS.items() if look.style}
"""Styles by word. The words say everything without a colour too."""
LEGEND = ", ".join(f"{look.symbol} {answer.value}" for answer, look in LOOKS.items())
"""What the symbols mean."""


def word_of(answer: Answer) -> str:
    """The answer as a badge shows it."""
    return answer.value.upper()


def symbol_of(answer: Answer) -> str:
    """The symbol of an answer."""
    return LOOKS[answer].symbol


def badge_of(answer: Answer) -> str:
    """The class that colours an answer on a page."""
    return answer.name.lower().replace("_", "-")
