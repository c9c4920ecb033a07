"""What people see of an experiment: a table in the terminal and a page in the browser."""

from typing import TYPE_CHECKING, Any

from harness.face import look_up

if TYPE_CHECKING:
    from harness.report.document import report_text
    from harness.report.facts import shared_facts
    from harness.report.figures.chart import Axis, Chart, Dots, Line, linear_axis
    from harness.report.figures.draw import draw_chart
    from harness.report.figures.learning import describe_learning, draw_learning
    from harness.report.figures.split_rows import describe_split
    from harness.report.page.eta import write_eta_page
    from harness.report.page.html import write_html
    from harness.report.replay.section import replay_of
    from harness.report.rows.behaviour import along_grid, behaviour_grids
    from harness.report.rows.comparison import basis_text, beside_answer, question, what_decides
    from harness.report.rows.payoff import Payoffs
    from harness.report.rows.race import race_told
    from harness.report.rows.ratios import SPLIT, Grid, format_number, scales_text
    from harness.report.rows.returns import return_grid
    from harness.report.rows.terms import terms_grid
    from harness.report.tables.comparison import comparison_table
    from harness.report.tables.eta import eta_table
    from harness.report.tables.overview import overview_table
    from harness.report.tables.ranking import ranking_table
    from harness.report.tables.score import score_table
    from harness.report.typography import typeset

__all__ = [
    "SPLIT",
    "Axis",
    "Chart",
    "Dots",
    "Grid",
    "Line",
    "Payoffs",
    "along_grid",
    "basis_text",
    "behaviour_grids",
    "beside_answer",
    "comparison_table",
    "describe_learning",
    "describe_split",
    "draw_chart",
    "draw_learning",
    "eta_table",
    "format_number",
    "linear_axis",
    "overview_table",
    "question",
    "race_told",
    "ranking_table",
    "replay_of",
    "report_text",
    "return_grid",
    "scales_text",
    "score_table",
    "shared_facts",
    "terms_grid",
    "typeset",
    "what_decides",
    "write_eta_page",
    "write_html",
]

_HOMES = {
    "document": "report_text",
    "facts": "shared_facts",
    "figures.chart": "Axis Chart Dots Line linear_axis",
    "figures.draw": "draw_chart",
    "figures.learning": "describe_learning draw_learning",
    "figures.split_rows": "describe_split",
    "page.eta": "write_eta_page",
    "page.html": "write_html",
    "replay.section": "replay_of",
    "rows.behaviour": "along_grid behaviour_grids",
    "rows.comparison": "basis_text beside_answer question what_decides",
    "rows.payoff": "Payoffs",
    "rows.race": "race_told",
    "rows.ratios": "SPLIT Grid format_number scales_text",
    "rows.returns": "return_grid",
    "rows.terms": "terms_grid",
    "tables.comparison": "comparison_table",
    "tables.eta": "eta_table",
    "tables.overview": "overview_table",
    "tables.ranking": "ranking_table",
    "tables.score": "score_table",
    "typography": "typeset",
}


def __getattr__(name: str) -> Any:
    return look_up(__name__, _HOMES, name)
