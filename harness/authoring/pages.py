"""What pages and tables of results are written with: sentences, grids, figures. Commands of our own use it too."""

# ruff: noqa: PLC0414 -- `X as X` tells type checkers that the name is public

from typing import TYPE_CHECKING

from harness.face import face_of

if TYPE_CHECKING:
    from harness.eta.headline import (
        interval_text as interval_text,
        is_drawable as is_drawable,
        ratio_text as ratio_text,
        ratio_with_interval as ratio_with_interval,
    )
    from harness.report.document import Fact as Fact
    from harness.report.figures.accumulated import (
        FEWEST as FEWEST,
        POINTS as POINTS,
        CurvePanel as CurvePanel,
        draw_both as draw_both,
        panels_of as panels_of,
        reward_range as reward_range,
        select_points as select_points,
    )
    from harness.report.figures.chart import (
        SIDES as SIDES,
        Mark as Mark,
        chart_style as chart_style,
        light_colours as light_colours,
    )
    from harness.report.figures.draw import (
        CHARACTER as CHARACTER,
        SAMPLE as SAMPLE,
        draw_figure as draw_figure,
        draw_sample as draw_sample,
        figure_height as figure_height,
        legend_of as legend_of,
        panel_left as panel_left,
        set_text as set_text,
        width_of as width_of,
    )
    from harness.report.figures.learning import (
        flat_text as flat_text,
        learning_heading as learning_heading,
        learning_names as learning_names,
    )
    from harness.report.figures.split import (
        SplitRow as SplitRow,
        draw_ratio as draw_ratio,
        draw_split as draw_split,
        number_of as number_of,
        ratio_axis as ratio_axis,
    )
    from harness.report.page.answer import plain_text as plain_text
    from harness.report.page.page import render_page as render_page, write_page as write_page
    from harness.report.replay.section import Replay as Replay
    from harness.report.rows.comparison import (
        ALONE as ALONE,
        CHOOSING as CHOOSING,
        CHOOSING_TITLE as CHOOSING_TITLE,
        POOLED as POOLED,
        POOLED_TITLE as POOLED_TITLE,
        alone_grid as alone_grid,
        behaviour_row as behaviour_row,
        compared_text as compared_text,
        count_cells as count_cells,
        interim_line as interim_line,
        interim_text as interim_text,
        percentage as percentage,
        pooled_answers as pooled_answers,
        remarks_on_cells as remarks_on_cells,
        rewards_text as rewards_text,
        seeds_text as seeds_text,
        setting_of as setting_of,
        story as story,
        tell_apart as tell_apart,
        text_of as text_of,
        word_of as word_of,
    )
    from harness.report.rows.ratios import (
        BETTER as BETTER,
    )
    from harness.report.rows.returns import (
        PAY as PAY,
        number_grids as number_grids,
        splits_of as splits_of,
        terms_of as terms_of,
    )
    from harness.report.tables.comparison import WideOrNarrow as WideOrNarrow, overview_grids as overview_grids
    from harness.report.tables.grid import show_grid as show_grid
    from harness.results.verdicts import UNKNOWN as UNKNOWN, missing_text as missing_text

else:
    __all__, __getattr__ = face_of(__name__, __file__)
