"""Text of strangers made fit to be shown: what a terminal, a page or a reader would obey or not see is written out."""

import unicodedata

LONGEST_MESSAGE = 300
"""Characters of a one-line message: about three lines of a terminal, beyond which nobody finds what to do."""
ELLIPSIS = " ... "
HIDDEN = ("Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp")
"""Categories of Unicode that are escaped: control characters of both sets, formats such as turns of the direction and
marks without width, halves of characters, what has no meaning yet, and separators of lines and paragraphs."""


def visible(text: str, keep: str = "") -> str:
    r"""The text with every character that is not seen, or that does something, as an escape: ``\x1b``, ``\u202e``.

    Letters of all languages and ordinary blanks stay as they are.

    Args:
        text: Of whatever origin.
        keep: Such characters that may stay, as a line break in a text of several lines.
    """
    if text.isprintable():
        return text
    return "".join(char if char in keep else _escaped(char) for char in text)


def shortened(message: str, most: int = LONGEST_MESSAGE) -> str:
    """The message, of a long one the beginning, which says where, and the end, which says what to do."""
    if len(message) <= most:
        return message
    end = most // 3
    return message[: most - end - len(ELLIPSIS)] + ELLIPSIS + message[-end:]


def one_line_of(message: str) -> str:
    """The message as one visible line of at most `LONGEST_MESSAGE` characters."""
    return shortened(visible(" ".join(message.split())))


def _escaped(char: str) -> str:
    return char.encode("unicode_escape").decode("ascii") if unicodedata.category(char) in HIDDEN else char
