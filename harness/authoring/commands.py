"""What commands are written with: flags, output, an experiment's folder, runs, pages. Commands of our own use it too.

Every name is looked up when it is first used, so that importing this module imports nothing heavy.
"""

# ruff: noqa: PLC0414 -- `X as X` tells type checkers that the name is public

from typing import TYPE_CHECKING

from harness.authoring.face import lazy_names

if TYPE_CHECKING:
    from harness.cli.flags.shared import ALGORITHMS as ALGORITHMS
    from harness.cli.flags.shared import REWARDS as REWARDS
    from harness.cli.flags.shared import AsJson as AsJson
    from harness.cli.flags.shared import EvaluationEpisodes as EvaluationEpisodes
    from harness.cli.flags.shared import ExperimentFolder as ExperimentFolder
    from harness.cli.flags.shared import Names as Names
    from harness.cli.flags.shared import PluginFiles as PluginFiles
    from harness.cli.flags.shared import RobotName as RobotName
    from harness.cli.flags.shared import SimulatorNames as SimulatorNames
    from harness.cli.flags.shared import TaskName as TaskName
    from harness.cli.output import complain as complain
    from harness.cli.output import say as say
    from harness.cli.output import say_json as say_json
    from harness.cli.progress import LiveProgress as LiveProgress
    from harness.cli.records import Records as Records
    from harness.cli.terminal import show as show
    from harness.env import ReachVectorEnv as ReachVectorEnv
    from harness.env.make import World as World
    from harness.env.single_env import ReachEnv as ReachEnv
    from harness.eta.behaviour_change import Change as Change
    from harness.eta.behaviour_change import Quantity as Quantity
    from harness.eta.behaviour_change import with_intervals as with_intervals
    from harness.eta.curve import GroupCurve as GroupCurve
    from harness.eta.curve import curve_of as curve_of
    from harness.eta.headline import DECIDING as DECIDING
    from harness.eta.headline import SUCCESS as SUCCESS
    from harness.eta.headline import Answer as Answer
    from harness.eta.index import NOTHING as NOTHING
    from harness.eta.index import Index as Index
    from harness.eta.index import Ratio as Ratio
    from harness.eta.return_split import ReturnSplit as ReturnSplit
    from harness.eta.seed_mean import SeedMean as SeedMean
    from harness.eta.splits import Decomposition as Decomposition
    from harness.eta.splits import Split as Split
    from harness.eta.splits import SplitPath as SplitPath
    from harness.eta.splits import SumSplit as SumSplit
    from harness.eta.splits import no_splits as no_splits
    from harness.experiment.environments.played_again import PlayedAgain as PlayedAgain
    from harness.experiment.plan import Plan as Plan
    from harness.experiment.plan import check_experiment as check_experiment
    from harness.experiment.plan import expand as expand
    from harness.experiment.provenance import describe_machine as describe_machine
    from harness.experiment.provenance import specs_of as specs_of
    from harness.experiment.provenance import versions_behind as versions_behind
    from harness.experiment.run_cell import run_cell as run_cell
    from harness.experiment.watch import Stage as Stage
    from harness.experiment.watch import Watch as Watch
    from harness.experiment.workers.order import Order as Order
    from harness.experiment.workers.order import Report as Report
    from harness.experiment.workers.workers import News as News
    from harness.experiment.workers.workers import run_orders as run_orders
    from harness.files.bounded import parse_json as parse_json
    from harness.files.bounded import read_bytes as read_bytes
    from harness.files.bounded import read_json as read_json
    from harness.files.bounded import read_text as read_text
    from harness.files.bounded import reading as reading
    from harness.files.parquet import require_room as require_room
    from harness.files.whole_file import whole_file as whole_file
    from harness.files.whole_file import write_whole as write_whole
    from harness.record.cell import NO_ROBOT as NO_ROBOT
    from harness.record.cell import NO_SIMULATOR as NO_SIMULATOR
    from harness.record.cell import Cell as Cell
    from harness.record.file_forms import Status as Status
    from harness.record.file_forms import require_form as require_form
    from harness.record.folder import partial_folder as partial_folder
    from harness.record.folder import publish as publish
    from harness.record.manifest import Manifest as Manifest
    from harness.record.manifest import read_manifest as read_manifest
    from harness.record.plan_file import EXPERIMENT as EXPERIMENT
    from harness.record.plan_file import PLAN as PLAN
    from harness.record.scene import Scene as Scene
    from harness.registry.choice import Choice as Choice
    from harness.registry.choice import choose as choose
    from harness.registry.choice import parse as parse
    from harness.registry.choice import split_list as split_list
    from harness.registry.given import Given as Given
    from harness.registry.given import given_from_json as given_from_json
    from harness.registry.given import given_to_json as given_to_json
    from harness.registry.given import read_given as read_given
    from harness.registry.names import unknown_name as unknown_name
    from harness.registry.registry import Registry as Registry
    from harness.registry.registry import load_registry as load_registry
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
    from harness.results.alone import Alone as Alone
    from harness.results.cell_results import PAID as PAID
    from harness.results.comparison import Comparison as Comparison
    from harness.results.comparison import Group as Group
    from harness.results.comparison import deciding_manner as deciding_manner
    from harness.results.comparison import pools_of as pools_of
    from harness.results.learning import Learning as Learning
    from harness.results.learning import LearningCurve as LearningCurve
    from harness.results.learning import Point as Point
    from harness.results.overview import decided_by_text as decided_by_text
    from harness.results.overview import overview_of as overview_of
    from harness.results.overview import short_name as short_name
    from harness.results.overview import values_text as values_text
    from harness.results.recordings.results import RecordedResults as RecordedResults
    from harness.results.replay import Episode as Episode
    from harness.results.replay import Show as Show
    from harness.results.replay import Side as Side
    from harness.results.replay import find_done as find_done
    from harness.results.replay import first_show as first_show
    from harness.results.replay import show_cells as show_cells
    from harness.results.seen import ENDED as ENDED
    from harness.results.standing import told_manifests as told_manifests
    from harness.results.table import RANDOM as RANDOM
    from harness.results.verdicts import with_verdicts as with_verdicts
    from harness.robot.kinematics import end_effector_position as end_effector_position
    from harness.scene.picture import BACKGROUND as BACKGROUND
    from harness.scene.picture import TARGET as TARGET
    from harness.scene.picture import Camera as Camera
    from harness.scene.picture import camera_for as camera_for
    from harness.scene.picture import chain_of as chain_of
    from harness.scene.picture import corners_of as corners_of
    from harness.scene.picture import draw_arm as draw_arm
    from harness.scene.picture import require_pillow as require_pillow
    from harness.testing.opened import closed_motion as closed_motion

_NAMES = {
    "harness.cli.flags.shared": (
        "ALGORITHMS",
        "AsJson",
        "EvaluationEpisodes",
        "ExperimentFolder",
        "Names",
        "PluginFiles",
        "REWARDS",
        "RobotName",
        "SimulatorNames",
        "TaskName",
    ),
    "harness.cli.output": ("complain", "say", "say_json"),
    "harness.cli.progress": ("LiveProgress",),
    "harness.cli.records": ("Records",),
    "harness.cli.terminal": ("show",),
    "harness.env": ("ReachVectorEnv",),
    "harness.env.make": ("World",),
    "harness.env.single_env": ("ReachEnv",),
    "harness.eta.behaviour_change": ("Change", "Quantity", "with_intervals"),
    "harness.eta.curve": ("GroupCurve", "curve_of"),
    "harness.eta.headline": ("Answer", "DECIDING", "SUCCESS"),
    "harness.eta.index": ("Index", "NOTHING", "Ratio"),
    "harness.eta.return_split": ("ReturnSplit",),
    "harness.eta.seed_mean": ("SeedMean",),
    "harness.eta.splits": ("Decomposition", "Split", "SplitPath", "SumSplit", "no_splits"),
    "harness.experiment.environments.played_again": ("PlayedAgain",),
    "harness.experiment.plan": ("Plan", "check_experiment", "expand"),
    "harness.experiment.provenance": ("describe_machine", "specs_of", "versions_behind"),
    "harness.experiment.run_cell": ("run_cell",),
    "harness.experiment.watch": ("Stage", "Watch"),
    "harness.experiment.workers.order": ("Order", "Report"),
    "harness.experiment.workers.workers": ("News", "run_orders"),
    "harness.files.bounded": ("parse_json", "read_bytes", "read_json", "read_text", "reading"),
    "harness.files.parquet": ("require_room",),
    "harness.files.whole_file": ("whole_file", "write_whole"),
    "harness.record.cell": ("Cell", "NO_ROBOT", "NO_SIMULATOR"),
    "harness.record.file_forms": ("Status", "require_form"),
    "harness.record.folder": ("partial_folder", "publish"),
    "harness.record.manifest": ("Manifest", "read_manifest"),
    "harness.record.plan_file": ("EXPERIMENT", "PLAN"),
    "harness.record.scene": ("Scene",),
    "harness.registry.choice": ("Choice", "choose", "parse", "split_list"),
    "harness.registry.given": ("Given", "given_from_json", "given_to_json", "read_given"),
    "harness.registry.names": ("unknown_name",),
    "harness.registry.registry": ("Registry", "load_registry"),
    "harness.report.answers": ("word_of",),
    "harness.report.apart": ("tell_apart",),
    "harness.report.document": ("report_text",),
    "harness.report.facts": ("Fact", "shared_facts"),
    "harness.report.figures.accumulated": ("draw_both",),
    "harness.report.figures.chart": ("Axis", "Chart", "Dots", "Line", "Mark"),
    "harness.report.figures.draw": (
        "CHARACTER",
        "SAMPLE",
        "draw_chart",
        "draw_figure",
        "draw_sample",
        "figure_height",
        "legend_of",
        "panel_left",
        "set_text",
        "width_of",
    ),
    "harness.report.figures.learning": (
        "describe_learning",
        "draw_learning",
        "flat_text",
        "learning_heading",
        "learning_names",
    ),
    "harness.report.figures.palette": ("SIDES", "chart_style", "light_colours"),
    "harness.report.figures.panel": ("CurvePanel", "Drawn", "panels_of", "reward_range"),
    "harness.report.figures.points": ("FEWEST", "POINTS"),
    "harness.report.figures.race": ("draw_race",),
    "harness.report.figures.ratio_axis": ("is_drawable", "ticks"),
    "harness.report.figures.split": ("draw_ratio", "draw_split", "number_of", "ratio_axis"),
    "harness.report.figures.split_rows": ("SplitRow", "describe_split"),
    "harness.report.page.matrix": ("plain_text",),
    "harness.report.page.page": ("render_page", "write_page"),
    "harness.report.rows.alone": ("ALONE", "alone_grid", "setting_of", "story"),
    "harness.report.rows.behaviour": ("along_grid", "behaviour_grids", "behaviour_row", "percentage", "text_of"),
    "harness.report.rows.comparison": (
        "TESTS",
        "answer_text",
        "basis_text",
        "beside_answer",
        "compared_text",
        "count_cells",
        "interim_line",
        "interim_text",
        "question",
        "remarks_on_cells",
        "rewards_text",
        "seeds_text",
        "what_decides",
    ),
    "harness.report.rows.numbers": ("number_grids", "splits_of"),
    "harness.report.rows.pools": ("POOLED", "POOLED_TITLE", "pooled_answers"),
    "harness.report.rows.race": ("RACE", "RACE_TITLE", "RaceTold", "race_told"),
    "harness.report.rows.ratios": (
        "BETTER",
        "Grid",
        "SPLIT",
        "format_number",
        "ratio_text",
        "ratio_with_interval",
        "scales_text",
    ),
    "harness.report.rows.returns": ("MEAN",),
    "harness.report.rows.terms": ("terms_grid", "terms_of"),
    "harness.report.tables.grid": ("show_grid",),
    "harness.report.tables.overview": ("WideOrNarrow",),
    "harness.report.typography": ("typeset",),
    "harness.results.alone": ("Alone",),
    "harness.results.cell_results": ("PAID",),
    "harness.results.comparison": ("Comparison", "Group", "deciding_manner", "pools_of"),
    "harness.results.learning": ("Learning", "LearningCurve", "Point"),
    "harness.results.overview": ("decided_by_text", "overview_of", "short_name", "values_text"),
    "harness.results.recordings.results": ("RecordedResults",),
    "harness.results.replay": ("Episode", "Show", "Side", "find_done", "first_show", "show_cells"),
    "harness.results.seen": ("ENDED",),
    "harness.results.standing": ("told_manifests",),
    "harness.results.table": ("RANDOM",),
    "harness.results.verdicts": ("with_verdicts",),
    "harness.robot.kinematics": ("end_effector_position",),
    "harness.scene.picture": (
        "BACKGROUND",
        "Camera",
        "TARGET",
        "camera_for",
        "chain_of",
        "corners_of",
        "draw_arm",
        "require_pillow",
    ),
    "harness.testing.opened": ("closed_motion",),
}
"""The public names of each module."""

__all__ = sorted(name for names in _NAMES.values() for name in names)  # noqa: PLE0605

__getattr__ = lazy_names(__name__, {name: home for home, names in _NAMES.items() for name in names}, {})
