"""One HTML file that opens anywhere, offline, and what its text looks like."""

import html
import re
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from harness.errors import UsageError
from harness.files.bounded import write_whole
from harness.report.figures.chart import STYLE

THIN = "\u202f"
"""The space between a number and its unit: narrow, and no line ends there."""
SIGNS = {"x": "×", "->": "→", "<=": "≤", ">=": "≥"}
"""Signs that stand between two spaces."""
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
BEFORE = r"(?<![^\s\[(−])"
"""Where a number begins: at the beginning of the text, or behind a space, a bracket or a minus."""
UNITS = "%|°|s|ms|µs|min|h|mm|cm|m|km|rad|N|Nm|kg|g|Hz|kHz|px|pp|B|kB|MB|GB|TB|KiB|MiB|GiB"

SIGN = re.compile(r"(?<=\s)(?:x|->|<=|>=)(?=\s)|^x(?=\s\d)")
MINUS = re.compile(BEFORE + r"-(?=\.?\d)")
SCIENTIFIC = re.compile(BEFORE + r"(\d+(?:\.\d+)?)e([+-]?)0*(\d+)(?![\w.])")
POWER = re.compile(r"(?<=[\w)])\^(-?\d+)\b")
UNIT = re.compile(rf"(?<=\d)(?: ?(?=%)| (?=(?:{UNITS})(?![\w:=])))")
SYMBOL = re.compile(r"\b(?:(eta|I)_([NP])|eta)\b(?![:=]\S)")
NAME = re.compile(r"`([^`\s]+)`")


class Piece(NamedTuple):
    """A part of a text that is set in one way."""

    text: str
    is_subscript: bool = False


def typeset(text: str) -> str:
    """A text with its signs: ×, −, →, ≤, ≥, powers of ten and of units, and narrow spaces before units and %.

    Symbols with a subscript, such as eta_N, stay: `pieces_of` and `to_html` set them. A text that is set already stays.
    """
    text = SIGN.sub(lambda found: SIGNS[found[0]], text)
    text = MINUS.sub("−", text)
    text = SCIENTIFIC.sub(_power_of_ten, text)
    text = POWER.sub(lambda found: found[1].translate(RAISED), text)
    return UNIT.sub(THIN, text)


def pieces_of(text: str) -> list[Piece]:
    """The parts of a text that is `typeset`: eta_N is an η and the subscript N, I_P an I and P, eta an η."""
    text, pieces, end = typeset(text), list[Piece](), 0
    for found in SYMBOL.finditer(text):
        symbol = "I" if found[1] == "I" else "η"
        pieces.append(Piece(text[end : found.start()] + symbol))
        pieces += [Piece(found[2], True)] if found[2] else []
        end = found.end()
    return _joined([*pieces, Piece(text[end:])])


def to_html(text: str) -> str:
    """The same as HTML: escaped, with ``<sub>``, and with ``<code>`` where a name stands between backticks."""
    parts = ((html.escape(it.text), it.is_subscript) for it in pieces_of(text))
    told = "".join(f"<sub>{part}</sub>" if is_subscript else part for part, is_subscript in parts)
    return NAME.sub(r"<code>\1</code>", told)


def _power_of_ten(found: re.Match[str]) -> str:
    digits, sign, exponent = found.groups()
    power = f"10{(sign.replace('+', '') + exponent).translate(RAISED)}"
    return power if digits == "1" else f"{digits} × {power}"


def _joined(pieces: list[Piece]) -> list[Piece]:
    """Without empty parts, and parts beside one another that are set alike as one."""
    joined = list[Piece]()
    for piece in pieces:
        if joined and joined[-1].is_subscript == piece.is_subscript:
            joined[-1] = Piece(joined[-1].text + piece.text, piece.is_subscript)
        elif piece.text:
            joined.append(piece)
    return joined


def render_page(template: Path, noun: str, **values: Any) -> str:
    """The page that `template` makes of `values`; it may include what lies beside this module, such as the style sheet.

    Raises:
        UsageError: The extra ``report`` is missing; `noun` says what for.
    """
    try:
        import jinja2
    except ImportError as error:
        raise UsageError(f"{noun} needs {error.name}: pip install 'fd100-harness[report]'") from error
    page: str = _environment(template.parent, jinja2).get_template(template.name).render(**values)
    return page


@lru_cache(maxsize=8)
def _environment(folder: Path, jinja2: Any) -> Any:
    """One jinja2 environment for all pages of a folder's templates. It keeps the templates compiled."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader([folder, Path(__file__).parent, STYLE.parent]),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["typeset"] = _typeset
    return environment


def _typeset(text: str) -> Any:
    """A text as print has it, escaped: signs instead of letters, subscripts, narrow spaces before units."""
    from markupsafe import Markup

    return Markup(to_html(text))


def write_page(page: str, path: Path, noun: str) -> None:
    """Write `page` to `path`, in one go: a reader finds the old file or the new one, whole.

    Raises:
        UsageError: `path` cannot be written.
    """
    try:
        write_whole(path, page)
    except OSError as error:
        raise UsageError(f"{noun} '{path}' cannot be written: {error.strerror}") from error
