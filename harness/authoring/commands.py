"""What commands are written with: flags, output, an experiment's folder, runs, pages. Commands of our own use it too.

Every name is looked up when it is first used, so that importing this module imports nothing heavy.
"""

# ruff: noqa: PLC0414 -- `X as X` tells type checkers that the name is public

from typing import TYPE_CHECKING

from harness.authoring.face import homes_in, lazy_names

if TYPE_CHECKING:
    from harness.cli.flags.shared import ALGORITHMS as ALGORITHMS, AsJson as AsJson, EvaluationEpisodes as EvaluationEpisodes, ExperimentFolder as ExperimentFolder, Names as Names, PluginFiles as PluginFiles, REWARDS as REWARDS, ROBOT as ROBOT, RobotName as RobotName, SimulatorNames as SimulatorNames, TaskName as TaskName
    from harness.cli.output import complain as complain, say as say, say_json as say_json
    from harness.cli.progress import LiveProgress as LiveProgress
    from harness.cli.terminal import show as show
    from harness.env import ReachVectorEnv as ReachVectorEnv
    from harness.env.make import World as World
    from harness.env.single_env import ReachEnv as ReachEnv
    from harness.env.solid_probes import find_missing as find_missing, missing_in_words as missing_in_words, probes_of as probes_of
    from harness.eta.behaviour_change import Change as Change, Quantity as Quantity, with_intervals as with_intervals
    from harness.eta.curve import GroupCurve as GroupCurve, curve_of as curve_of
    from harness.eta.headline import Answer as Answer, DECIDING as DECIDING, SUCCESS as SUCCESS
    from harness.eta.index import Index as Index, NOTHING as NOTHING, Ratio as Ratio
    from harness.eta.return_split import ReturnSplit as ReturnSplit
    from harness.eta.seed_mean import SeedMean as SeedMean
    from harness.eta.splits import Decomposition as Decomposition, Split as Split, SplitPath as SplitPath, SumSplit as SumSplit, no_splits as no_splits
    from harness.experiment.environments.played_again import PlayedAgain as PlayedAgain
    from harness.experiment.plan import Plan as Plan, check_experiment as check_experiment, expand as expand
    from harness.experiment.provenance import describe_machine as describe_machine, specs_of as specs_of, versions_behind as versions_behind
    from harness.experiment.run_cell import run_cell as run_cell
    from harness.experiment.watch import Stage as Stage, Watch as Watch
    from harness.experiment.workers.order import Order as Order, Report as Report
    from harness.experiment.workers.workers import News as News, run_orders as run_orders
    from harness.files.bounded import parse_json as parse_json, read_bytes as read_bytes, read_json as read_json, read_text as read_text, reading as reading
    from harness.files.parquet import require_room as require_room
    from harness.files.whole_file import whole_file as whole_file, write_whole as write_whole
    from harness.record.cell import Cell as Cell, NO_ROBOT as NO_ROBOT, NO_SIMULATOR as NO_SIMULATOR
    from harness.record.file_forms import Status as Status, require_form as require_form
    from harness.record.folder import partial_folder as partial_folder, publish as publish
    from harness.record.manifest import Manifest as Manifest, read_manifest as read_manifest
    from harness.record.plan_file import EXPERIMENT as EXPERIMENT, PLAN as PLAN
    from harness.record.scene import Scene as Scene
    from harness.registry.choice import Choice as Choice, choose as choose, parse as parse, split_list as split_list
    from harness.registry.given import Given as Given, given_from_json as given_from_json, given_to_json as given_to_json, read_given as read_given
    from harness.registry.names import unknown_name as unknown_name
    from harness.registry.registry import Registry as Registry, load_registry as load_registry
    from harness.report.answers import word_of as word_of
    from harness.report.apart import tell_apart as tell_apart
    from harness.report.document import report_text as report_text
    from harness.report.facts import Fact as Fact, shared_facts as shared_facts
    from harness.report.figures.accumulated import draw_both as draw_both
    from harness.report.figures.chart import Axis as Axis, Chart as Chart, Dots as Dots, Line as Line, Mark as Mark
    from harness.report.figures.draw import CHARACTER as CHARACTER, SAMPLE as SAMPLE, draw_chart as draw_chart, draw_figure as draw_figure, draw_sample as draw_sample, figure_height as figure_height, legend_of as legend_of, panel_left as panel_left, set_text as set_text, width_of as width_of
    from harness.report.figures.learning import describe_learning as describe_learning, draw_learning as draw_learning, flat_text as flat_text, learning_heading as learning_heading, learning_names as learning_names
    from harness.report.figures.palette import SIDES as SIDES, chart_style as chart_style, light_colours as light_colours
    from harness.report.figures.panel import CurvePanel as CurvePanel, Drawn as Drawn, panels_of as panels_of, reward_range as reward_range
    from harness.report.figures.points import FEWEST as FEWEST, POINTS as POINTS
    from harness.report.figures.race import draw_race as draw_race
    from harness.report.figures.ratio_axis import is_drawable as is_drawable, ticks as ticks
    from harness.report.figures.split import draw_ratio as draw_ratio, draw_split as draw_split, number_of as number_of, ratio_axis as ratio_axis
    from harness.report.figures.split_rows import SplitRow as SplitRow, describe_split as describe_split
    from harness.report.page.matrix import plain_text as plain_text
    from harness.report.page.page import render_page as render_page, write_page as write_page
    from harness.report.rows.alone import ALONE as ALONE, alone_grid as alone_grid, setting_of as setting_of, story as story
    from harness.report.rows.behaviour import along_grid as along_grid, behaviour_grids as behaviour_grids, behaviour_row as behaviour_row, percentage as percentage, text_of as text_of
    from harness.report.rows.comparison import TESTS as TESTS, answer_text as answer_text, basis_text as basis_text, beside_answer as beside_answer, compared_text as compared_text, count_cells as count_cells, interim_line as interim_line, interim_text as interim_text, question as question, remarks_on_cells as remarks_on_cells, rewards_text as rewards_text, seeds_text as seeds_text, what_decides as what_decides
    from harness.report.rows.numbers import number_grids as number_grids, splits_of as splits_of
    from harness.report.rows.pools import POOLED as POOLED, POOLED_TITLE as POOLED_TITLE, pooled_answers as pooled_answers
    from harness.report.rows.race import RACE as RACE, RACE_TITLE as RACE_TITLE, RaceTold as RaceTold, race_told as race_told
    from harness.report.rows.ratios import BETTER as BETTER, Grid as Grid, SPLIT as SPLIT, format_number as format_number, ratio_text as ratio_text, ratio_with_interval as ratio_with_interval, scales_text as scales_text
    from harness.report.rows.returns import MEAN as MEAN
    from harness.report.rows.terms import terms_grid as terms_grid, terms_of as terms_of
    from harness.report.tables.grid import show_grid as show_grid
    from harness.report.tables.overview import WideOrNarrow as WideOrNarrow
    from harness.report.typography import typeset as typeset
    from harness.results.alone import Alone as Alone
    from harness.results.cell_results import PAID as PAID
    from harness.results.comparison import Comparison as Comparison, Group as Group, deciding_manner as deciding_manner, pools_of as pools_of
    from harness.results.learning import Learning as Learning, LearningCurve as LearningCurve, Point as Point
    from harness.results.overview import decided_by_text as decided_by_text, overview_of as overview_of, short_name as short_name, values_text as values_text
    from harness.results.recordings.results import RecordedResults as RecordedResults
    from harness.results.replay import Episode as Episode, Show as Show, Side as Side, find_done as find_done, first_show as first_show, show_cells as show_cells
    from harness.results.seen import ENDED as ENDED
    from harness.results.standing import told_manifests as told_manifests
    from harness.results.table import RANDOM as RANDOM
    from harness.results.verdicts import with_verdicts as with_verdicts
    from harness.robot.kinematics import end_effector_position as end_effector_position
    from harness.scene.picture import BACKGROUND as BACKGROUND, Camera as Camera, TARGET as TARGET, camera_for as camera_for, chain_of as chain_of, corners_of as corners_of, draw_arm as draw_arm, require_pillow as require_pillow

_HOMES = homes_in(__file__)

__all__ = sorted(_HOMES)  # noqa: PLE0605

__getattr__ = lazy_names(__name__, _HOMES, {})
