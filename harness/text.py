"""Text of strangers made fit to be shown: what a terminal, a page or a reader would obey or not see is written out.

`print_visible` is the only way to a terminal, beside `harness.report.tables.grid` for tables.
"""

import hashlib
import os
import re
import shlex
import sys
import unicodedata
from collections.abc import Iterable
from pathlib import Path

LONGEST_MESSAGE = 300
"""Characters of a one-line message: about three lines of a terminal, beyond which nobody finds what to do."""
LONGEST_STEM = 120
"""Characters of a file name that is made of text, its ending left out."""
ELLIPSIS = " ... "
LONGEST_WORD = 60
"""Characters of a word that is left out whole where a message is cut; names in lists are shorter."""
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
    hidden = [char for char in set(text) if char not in keep and unicodedata.category(char) in HIDDEN]
    return text.translate({ord(char): char.encode("unicode_escape").decode("ascii") for char in hidden})


def print_visible(text: str, err: bool = False) -> None:
    """Print lines of whatever origin, in the encoding of the stream; what is not seen, or does something, is escaped.

    Args:
        text: One line or several.
        err: Whether to print on standard error, not on standard output.
    """
    print(visible(text, keep="\n"), file=sys.stderr if err else sys.stdout, flush=True)


def shortened(message: str, most: int = LONGEST_MESSAGE) -> str:
    """The message, of a long one the beginning, which says where, and the end, which says what to do.

    It is cut between words, so that no name in a list is cut; only a word of more than `LONGEST_WORD` characters is. A
    flag to type at the end is kept with what it gets, for which the end may be twice as long.
    """
    if len(message) <= most:
        return message
    end = most // 3
    flag = message.rfind(" --", len(message) - 2 * end, len(message) - end + 3)
    end = end if flag < 0 else len(message) - flag - 1
    begin = most - end - len(ELLIPSIS)
    return (
        message[: _word_before(message, begin)].rstrip()
        + ELLIPSIS
        + message[_word_after(message, len(message) - end) :]
    )


def one_line(told: BaseException | str, most: int = LONGEST_MESSAGE) -> str:
    """A text, or an exception as ``ValueError: no such thing``, on one visible line of about `most` characters.

    A long one has its beginning and its end, cut between words. What is not seen, or does something, is escaped.
    """
    text = told if isinstance(told, str) else f"{type(told).__name__}: {told}".removesuffix(": ")
    return shortened(visible(" ".join(text.split())), most)


def command_text(*words: str | Path) -> str:
    """A command as it is shown: whoever pastes it into a shell gives the command these words, and gives it no other.

    Args:
        words: The command's name, its flags and what they get. A `Path` is never taken for a flag.
    """
    return " ".join(map(_quoted, words))


def file_stems(texts: Iterable[str]) -> list[str]:
    """A name for a file for each text: lower-case letters, digits, dots and hyphens; no two are alike.

    A long one is cut and ends in a hash of the text.
    """
    stems: dict[str, None] = {}
    for text in texts:
        stem, number = _stem(text), 2
        free = stem
        while free in stems:
            free, number = f"{stem}-{number}", number + 1
        stems[free] = None
    return list(stems)


def _quoted(word: str | Path) -> str:
    r"""The word as a shell reads it; one with characters that are not seen as bash and zsh read it, ``$'\x1b'``."""
    text = str(word)
    if isinstance(word, Path) and text.startswith("-"):
        text = os.path.join(os.curdir, text)
    if visible(text) == text:
        return shlex.quote(text)
    return f"$'{''.join(map(_in_bytes, text))}'"


def _in_bytes(char: str) -> str:
    if char in "\\'":
        return f"\\{char}"
    if visible(char) == char:
        return char
    errors = "surrogateescape" if "\udc80" <= char <= "\udcff" else "surrogatepass"
    return "".join(f"\\x{byte:02x}" for byte in char.encode(errors=errors))


def _word_before(text: str, at: int) -> int:
    """Where the word begins that `at` lies in; `at` itself between two words, and in a long word."""
    begin = text.rfind(" ", 0, at + 1) + 1
    return begin if at - begin <= LONGEST_WORD else at


def _word_after(text: str, at: int) -> int:
    """Where the next word begins; `at` itself where a word begins there, and in a long word."""
    begin = text.find(" ", at - 1) + 1
    return begin if 0 < begin <= at + LONGEST_WORD else at


def _stem(text: str) -> str:
    stem = re.sub(r"[^a-z0-9.]+", "-", text.lower()).strip("-.") or "unnamed"
    if len(stem) <= LONGEST_STEM:
        return stem
    digest = hashlib.sha256(text.encode()).hexdigest()[:8]
    return f"{stem[: LONGEST_STEM - 9]}-{digest}"


def number(value: float) -> str:
    """Three significant digits, and no exponent where that is readable."""
    text = f"{value:.3g}" if abs(value) >= 1e-9 else "0"
    return f"{value:,.0f}" if "e+" in text and abs(value) < 1e9 else text
