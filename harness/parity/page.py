"""A parity as one HTML file that opens anywhere, offline."""

from pathlib import Path

from harness.parity.figure import draw_joints, draw_tips
from harness.parity.grids import failures, not_installed, pair_grids, setting_text, simulator_grid, title, verdict
from harness.parity.parity import Parity
from harness.report.page import render_page, write_page

TEMPLATE = Path(__file__).parent / "parity.html.j2"


def write_parity(parity: Parity, path: Path) -> None:
    """Write figures and tables to `path`.

    Raises:
        UsageError: A library of the extra ``report`` is missing, or `path` cannot be written.
    """
    panels = [("Tips", draw_tips(parity)), ("Joints", draw_joints(parity))] if parity.pairs else []
    grids = [grid for grid in (*pair_grids(parity), simulator_grid(parity)) if grid.rows]
    page = render_page(
        TEMPLATE,
        "--html",
        title=title(parity),
        setting=setting_text(parity),
        verdict=verdict(parity),
        panels=panels,
        grids=grids,
        failures=failures(parity),
        not_installed=not_installed(parity),
    )
    write_page(page, path, "The page")
