"""What pages and tables of results are written with: sentences, grids, figures. Commands of our own use it too."""

# ruff: noqa: PLC0414 -- `X as X` tells type checkers that the name is public

from typing import TYPE_CHECKING

from harness.authoring.face import homes_in, lazy_names

if TYPE_CHECKING:
    from harness.report.answers import word_of as word_of
    from harness.report.apart import tell_apart as tell_apart
    from harness.report.document import report_text as report_text
    from harness.report.facts import Fact as Fact
    from harness.report.facts import shared_facts as shared_facts
    from harness.report.figures.accumulated import draw_both as draw_both
    from harness.report.figures.chart import Axis as Axis
    from harness.report.figures.chart import Chart as Chart
    from harness.report.figures.chart import Dots as Dots
    from harness.report.figures.chart import Line as Line
    from harness.report.figures.chart import Mark as Mark
    from harness.report.figures.chart import linear_axis as linear_axis
    from harness.report.figures.draw import CHARACTER as CHARACTER
    from harness.report.figures.draw import SAMPLE as SAMPLE
    from harness.report.figures.draw import draw_chart as draw_chart
    from harness.report.figures.draw import draw_figure as draw_figure
    from harness.report.figures.draw import draw_sample as draw_sample
    from harness.report.figures.draw import figure_height as figure_height
    from harness.report.figures.draw import legend_of as legend_of
    from harness.report.figures.draw import panel_left as panel_left
    from harness.report.figures.draw import set_text as set_text
    from harness.report.figures.draw import width_of as width_of
    from harness.report.figures.learning import describe_learning as describe_learning
    from harness.report.figures.learning import draw_learning as draw_learning
    from harness.report.figures.learning import flat_text as flat_text
    from harness.report.figures.learning import learning_heading as learning_heading
    from harness.report.figures.learning import learning_names as learning_names
    from harness.report.figures.palette import SIDES as SIDES
    from harness.report.figures.palette import chart_style as chart_style
    from harness.report.figures.palette import light_colours as light_colours
    from harness.report.figures.panel import CurvePanel as CurvePanel
    from harness.report.figures.panel import Drawn as Drawn
    from harness.report.figures.panel import panels_of as panels_of
    from harness.report.figures.panel import reward_range as reward_range
    from harness.report.figures.points import FEWEST as FEWEST
    from harness.report.figures.points import POINTS as POINTS
    from harness.report.figures.points import select_points as select_points
    from harness.report.figures.race import draw_race as draw_race
    from harness.report.figures.ratio_axis import is_drawable as is_drawable
    from harness.report.figures.ratio_axis import ticks as ticks
    from harness.report.figures.split import draw_ratio as draw_ratio
    from harness.report.figures.split import draw_split as draw_split
    from harness.report.figures.split import number_of as number_of
    from harness.report.figures.split import ratio_axis as ratio_axis
    from harness.report.figures.split_rows import SplitRow as SplitRow
    from harness.report.figures.split_rows import describe_split as describe_split
    from harness.report.page.matrix import plain_text as plain_text
    from harness.report.page.page import render_page as render_page
    from harness.report.page.page import write_page as write_page
    from harness.report.replay.section import replay_of as replay_of
    from harness.report.rows.alone import ALONE as ALONE
    from harness.report.rows.alone import alone_grid as alone_grid
    from harness.report.rows.alone import setting_of as setting_of
    from harness.report.rows.alone import story as story
    from harness.report.rows.behaviour import along_grid as along_grid
    from harness.report.rows.behaviour import behaviour_grids as behaviour_grids
    from harness.report.rows.behaviour import behaviour_row as behaviour_row
    from harness.report.rows.behaviour import percentage as percentage
    from harness.report.rows.behaviour import text_of as text_of
    from harness.report.rows.comparison import TESTS as TESTS
    from harness.report.rows.comparison import answer_text as answer_text
    from harness.report.rows.comparison import basis_text as basis_text
    from harness.report.rows.comparison import beside_answer as beside_answer
    from harness.report.rows.comparison import compared_text as compared_text
    from harness.report.rows.comparison import count_cells as count_cells
    from harness.report.rows.comparison import interim_line as interim_line
    from harness.report.rows.comparison import interim_text as interim_text
    from harness.report.rows.comparison import question as question
    from harness.report.rows.comparison import remarks_on_cells as remarks_on_cells
    from harness.report.rows.comparison import rewards_text as rewards_text
    from harness.report.rows.comparison import seeds_text as seeds_text
    from harness.report.rows.comparison import what_decides as what_decides
    from harness.report.rows.numbers import number_grids as number_grids
    from harness.report.rows.numbers import splits_of as splits_of
    from harness.report.rows.pools import POOLED as POOLED
    from harness.report.rows.pools import POOLED_TITLE as POOLED_TITLE
    from harness.report.rows.pools import pooled_answers as pooled_answers
    from harness.report.rows.race import RACE as RACE
    from harness.report.rows.race import RACE_TITLE as RACE_TITLE
    from harness.report.rows.race import RaceTold as RaceTold
    from harness.report.rows.race import race_told as race_told
    from harness.report.rows.ratios import BETTER as BETTER
    from harness.report.rows.ratios import SPLIT as SPLIT
    from harness.report.rows.ratios import Grid as Grid
    from harness.report.rows.ratios import format_number as format_number
    from harness.report.rows.ratios import ratio_text as ratio_text
    from harness.report.rows.ratios import ratio_with_interval as ratio_with_interval
    from harness.report.rows.ratios import scales_text as scales_text
    from harness.report.rows.returns import MEAN as MEAN
    from harness.report.rows.terms import terms_grid as terms_grid
    from harness.report.rows.terms import terms_of as terms_of
    from harness.report.tables.grid import show_grid as show_grid
    from harness.report.tables.overview import WideOrNarrow as WideOrNarrow
    from harness.report.typography import typeset as typeset

else:
    _HOMES = homes_in(__file__)
    __all__ = sorted(_HOMES)  # noqa: PLE0605
    __getattr__ = lazy_names(__name__, _HOMES, {})
