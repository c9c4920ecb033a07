"""What people see of an experiment: a table in the terminal and a page in the browser."""

from typing import TYPE_CHECKING

from harness.face import face_of

if TYPE_CHECKING:
    from harness.eta.headline import format_number as format_number
    from harness.report.document import report_text as report_text, shared_facts as shared_facts
    from harness.report.facts import Report as Report, score_facts as score_facts
    from harness.report.figures.chart import (
        Axis as Axis,
        Chart as Chart,
        Dots as Dots,
        Line as Line,
        linear_axis as linear_axis,
    )
    from harness.report.figures.draw import draw_chart as draw_chart
    from harness.report.figures.learning import describe_learning as describe_learning, draw_learning as draw_learning
    from harness.report.figures.split import describe_split as describe_split
    from harness.report.page.eta import write_eta_page as write_eta_page
    from harness.report.page.html import write_html as write_html
    from harness.report.page.page import typeset as typeset
    from harness.report.replay.section import replay_of as replay_of
    from harness.report.rows import Fact as Fact, Grid as Grid
    from harness.report.rows.comparison import (
        along_grid as along_grid,
        basis_text as basis_text,
        behaviour_grids as behaviour_grids,
        beside_answer as beside_answer,
        choosing_facts as choosing_facts,
        question as question,
        what_decides as what_decides,
    )
    from harness.report.rows.ratios import (
        SPLIT as SPLIT,
        eta_facts as eta_facts,
        scales_text as scales_text,
    )
    from harness.report.rows.returns import Payoffs as Payoffs, return_grid as return_grid, terms_grid as terms_grid
    from harness.report.tables.grid import FactsTable as FactsTable
else:
    __all__, __getattr__ = face_of(__name__)
