"""A parity as one HTML file that opens anywhere, offline."""

from pathlib import Path

from harness.report.figures.draw import draw_chart
from harness.report.page.page import render_page, write_page

from .class_grids import class_grid, classes_text, response_grid
from .figure import JOINTS, TIPS, draw_all_pairs, draw_pairs
from .grids import (
    contact_text,
    engines_text,
    failures,
    not_installed,
    pair_grids,
    reference_pairs,
    setting_text,
    simulator_grid,
    title,
    verdict,
)
from .parity import Parity

TEMPLATE = Path(__file__).parent / "parity.html.j2"
TOLD = "how far two simulators are apart over time. The tables have the largest values."


def write_parity(parity: Parity, path: Path) -> None:
    """Write figures and tables to `path`.

    Raises:
        UsageError: A library of the extra ``report`` is missing, or `path` cannot be written.
    """
    curves = [("Tips", TIPS), ("Joints", JOINTS)] if parity.pairs else []
    everything = [(heading, draw_all_pairs(parity, curve)) for heading, curve in curves]
    grids = [grid for grid in (*pair_grids(parity), simulator_grid(parity)) if grid.rows]
    first = reference_pairs(parity) or list(parity.pairs)
    rest = [pair for pair in parity.pairs if pair not in first]
    folded = [grid for grid in (class_grid(parity, rest), response_grid(parity)) if grid.rows]
    page = render_page(
        TEMPLATE,
        "--html",
        title=title(parity),
        setting=setting_text(parity),
        verdict=verdict(parity),
        contact=contact_text(parity),
        engines=engines_text(parity),
        panels=[(heading, draw_chart(draw_pairs(parity, curve), f"{heading}: {TOLD}")) for heading, curve in curves],
        all_panels=[(heading, draw_chart(chart, f"{heading}: {TOLD}")) for heading, chart in everything if chart],
        grids=grids,
        classes=classes_text(parity) if first else "",
        by_class=class_grid(parity, first),
        by_class_too=folded if first else [],
        failures=failures(parity),
        not_installed=not_installed(parity),
    )
    write_page(page, path, "The page")
