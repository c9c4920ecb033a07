"""A parity as one HTML file that opens anywhere, offline."""

from pathlib import Path

from harness.errors import UsageError
from harness.parity.figure import draw_joints, draw_tips
from harness.parity.grids import pair_grids, remarks, setting_text, simulator_grid, title, verdict
from harness.parity.parity import Parity

TEMPLATE = "parity.html.j2"


def write_page(parity: Parity, path: Path) -> None:
    """Write figures and tables to `path`.

    Raises:
        UsageError: A library of the extra ``report`` is missing, or `path` cannot be written.
    """
    page = _render(parity)
    try:
        path.write_text(page, encoding="utf-8")
    except OSError as error:
        raise UsageError(f"The page '{path}' cannot be written: {error.strerror}") from error


def _render(parity: Parity) -> str:
    try:
        import jinja2
        from plotly.offline import get_plotlyjs
    except ImportError as error:
        raise UsageError(f"--html needs {error.name}: pip install 'fd100-harness[report]'") from error
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    panels = [("Tips", draw_tips(parity)), ("Joints", draw_joints(parity))] if parity.pairs else []
    grids = [grid for grid in (*pair_grids(parity), simulator_grid(parity)) if grid.rows]
    return environment.get_template(TEMPLATE).render(
        title=title(parity),
        setting=setting_text(parity),
        verdict=verdict(parity),
        panels=panels,
        grids=grids,
        remarks=remarks(parity),
        plotly_js=get_plotlyjs(),
    )
