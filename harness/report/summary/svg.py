"""Static figures: SVG by matplotlib, the same bytes from the same numbers."""

import re
from collections.abc import Callable
from io import BytesIO
from typing import TYPE_CHECKING, Any

from harness.errors import UsageError
from harness.report.palette import GRID, INK

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CREATOR = "harness report --summary"
"""Written into every figure: which figures in a folder are ours."""
STYLE: dict[str, Any] = {
    "svg.fonttype": "none",  # text stays text: it can be found, read out and scaled
    "svg.hashsalt": "harness",  # ids would be random
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],  # comes with matplotlib and is wide: another font in its place leaves room
    "font.size": 10,
    "text.parse_math": False,  # a label is no formula
    "text.color": INK,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.titlesize": 10.5,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.unicode_minus": False,
    "grid.color": GRID,
    "xtick.color": INK,
    "ytick.color": INK,
    "figure.facecolor": "#ffffff",  # readable on a dark page too
    "figure.constrained_layout.w_pad": 0.1,  # [inch]; numbers beside a panel keep off the edge
    "figure.constrained_layout.h_pad": 0.08,
    "lines.solid_joinstyle": "round",
    "path.simplify": False,
}


def require_matplotlib() -> None:
    """See to it that figures can be drawn.

    Raises:
        UsageError: matplotlib is not installed.
    """
    try:
        import matplotlib.backends.backend_svg  # noqa: F401
    except ImportError as error:
        raise UsageError(f"--summary needs {error.name}: pip install 'fd100-harness[figures]'") from error


def draw_svg(title: str, width: float, height: float, draw: Callable[["Figure"], None]) -> bytes:
    """A figure as a file.

    Args:
        title: What it shows, for those who cannot see it.
        width: [inch]; a browser shows 96 pixels for each.
        height: [inch].
        draw: Fills it.
    """
    import matplotlib.style
    from matplotlib.figure import Figure

    with matplotlib.style.context(["default", STYLE]):  # whatever the user's own settings are
        figure = Figure(figsize=(width, height), layout="constrained")
        draw(figure)
        buffer = BytesIO()
        figure.savefig(buffer, format="svg", metadata={"Title": title, "Creator": CREATOR, "Date": None})
    return _shorten(buffer.getvalue().decode()).encode()


def _shorten(svg: str) -> str:
    """Coordinates of curves with two digits, which no eye can tell from six; no reference to a file on the web."""
    svg = re.sub(r"<!DOCTYPE.*?>\n", "", svg, flags=re.DOTALL)
    return re.sub(r' d="[^"]*"', lambda path: re.sub(r"(\.\d\d)\d+", r"\1", path[0]).replace(" \n", " "), svg)
