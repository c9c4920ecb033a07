"""What commands are written with: flags, output, an experiment's folder, runs, pages. Commands of our own use it too.

Every name is looked up when it is first used, so that importing this module imports nothing heavy.
"""

# ruff: noqa: PLC0414 -- `X as X` tells type checkers that the name is public

from typing import TYPE_CHECKING

from harness.authoring.face import lazy_names

if TYPE_CHECKING:
    from harness.audit.number import number as number
    from harness.cli.flags.shared import ALGORITHMS as ALGORITHMS
    from harness.cli.flags.shared import REWARDS as REWARDS
    from harness.cli.flags.shared import ROBOT as ROBOT
    from harness.cli.flags.shared import ROBOTS as ROBOTS
    from harness.cli.flags.shared import SIMULATORS as SIMULATORS
    from harness.cli.flags.shared import AsJson as AsJson
    from harness.cli.flags.shared import ExecutorName as ExecutorName
    from harness.cli.flags.shared import ExperimentFolder as ExperimentFolder
    from harness.cli.flags.shared import Jobs as Jobs
    from harness.cli.flags.shared import Measures as Measures
    from harness.cli.flags.shared import PluginFiles as PluginFiles
    from harness.cli.flags.shared import RewardNames as RewardNames
    from harness.cli.flags.shared import RobotName as RobotName
    from harness.cli.flags.shared import TaskName as TaskName
    from harness.cli.interrupted import kept_when_interrupted as kept_when_interrupted
    from harness.cli.output import complain as complain
    from harness.cli.output import say as say
    from harness.cli.output import say_json as say_json
    from harness.cli.progress import LiveProgress as LiveProgress
    from harness.cli.terminal import Terminal as Terminal
    from harness.cli.terminal import show as show
    from harness.env.make import build_world as build_world
    from harness.env.solid_probes import Probe as Probe
    from harness.env.solid_probes import few_points as few_points
    from harness.env.solid_probes import find_missing as find_missing
    from harness.env.solid_probes import missing_in_words as missing_in_words
    from harness.env.solid_probes import probes_of as probes_of
    from harness.eta.headline import SUCCESS as SUCCESS
    from harness.eta.index import NOTHING as NOTHING
    from harness.eta.seed_mean import SeedMean as SeedMean
    from harness.eta.seed_mean import mean_lost_share as mean_lost_share
    from harness.eta.seed_mean import mean_over_seeds as mean_over_seeds
    from harness.experiment.changed import changed_cells as changed_cells
    from harness.experiment.changed import refuse_changed as refuse_changed
    from harness.experiment.draft import draft_of as draft_of
    from harness.experiment.draft import leave_record as leave_record
    from harness.experiment.environments.paid_again import PayAgain as PayAgain
    from harness.experiment.evaluation.evaluator import Evaluator as Evaluator
    from harness.experiment.experiment import DEFAULT_FOLDER as DEFAULT_FOLDER
    from harness.experiment.experiment import ExperimentRun as ExperimentRun
    from harness.experiment.plan import DEFAULT_TASK as DEFAULT_TASK
    from harness.experiment.plan import Episodes as Episodes
    from harness.experiment.plan import Names as Names
    from harness.experiment.plan import Plan as Plan
    from harness.experiment.plan import Seed as Seed
    from harness.experiment.plan import SeedCount as SeedCount
    from harness.experiment.plan import Steps as Steps
    from harness.experiment.plan import check_experiment as check_experiment
    from harness.experiment.plan import expand as expand
    from harness.experiment.provenance import describe_environment as describe_environment
    from harness.experiment.run_options import RunOptions as RunOptions
    from harness.experiment.task_plan import table_of as table_of
    from harness.experiment.watch import UNWATCHED as UNWATCHED
    from harness.experiment.workers.order import Order as Order
    from harness.experiment.workers.order import Report as Report
    from harness.experiment.workers.workers import News as News
    from harness.experiment.workers.workers import run_orders as run_orders
    from harness.experiment.workers.workers import worker_count as worker_count
    from harness.experiment.world import world_of as world_of
    from harness.files.bounded import digest_of as digest_of
    from harness.files.bounded import read_bytes as read_bytes
    from harness.files.bounded import reading as reading
    from harness.files.whole_file import files_in as files_in
    from harness.files.whole_file import is_partial as is_partial
    from harness.files.whole_file import write_whole as write_whole
    from harness.log.log import BEHAVIOUR as BEHAVIOUR
    from harness.log.log import REWARD as REWARD
    from harness.log.log import episode_rows as episode_rows
    from harness.motion.limits import JointLimits as JointLimits
    from harness.policy.continuous import ContinuousNetwork as ContinuousNetwork
    from harness.policy.folder import read_folder as read_folder
    from harness.policy.network import MEAN as MEAN
    from harness.policy.network import STD as STD
    from harness.record.cell import Cell as Cell
    from harness.record.cell_folder import require_files as require_files
    from harness.record.episode_facts import episode_facts as episode_facts
    from harness.record.file_forms import ChoiceForm as ChoiceForm
    from harness.record.file_forms import EndingForm as EndingForm
    from harness.record.folder import EVALUATION as EVALUATION
    from harness.record.folder import EVALUATION_RECORDING as EVALUATION_RECORDING
    from harness.record.folder import MANIFEST as MANIFEST
    from harness.record.folder import POLICY as POLICY
    from harness.record.folder import TRACE as TRACE
    from harness.record.folder import TRAINING_RECORDING as TRAINING_RECORDING
    from harness.record.folder import WEIGHTS as WEIGHTS
    from harness.record.folder import partial_folder as partial_folder
    from harness.record.folder import publish as publish
    from harness.record.folder import recording_of as recording_of
    from harness.record.manifest import Ending as Ending
    from harness.record.manifest import now as now
    from harness.record.manifest import read_manifest as read_manifest
    from harness.record.manifest import read_record as read_record
    from harness.record.out_folder import folder_lock as folder_lock
    from harness.record.out_folder import make_folder as make_folder
    from harness.record.out_folder import refuse_links as refuse_links
    from harness.record.out_folder import storage_errors as storage_errors
    from harness.record.recording.csv_writing import write_recording_csv as write_recording_csv
    from harness.record.recording.facts import facts_of as facts_of
    from harness.record.recording.facts import term_column as term_column
    from harness.record.recording.recorded_training import FLAGS as FLAGS
    from harness.record.recording.recorded_training import is_recording as is_recording
    from harness.record.recording.recorded_training import read_recording as read_recording
    from harness.record.recording.recorded_training import recordings_in as recordings_in
    from harness.record.returns import mean_return as mean_return
    from harness.record.store import Store as Store
    from harness.record.trace import read_trace as read_trace
    from harness.recorder.walk import Walk as Walk
    from harness.registry.choice import Choice as Choice
    from harness.registry.choice import build_defaults as build_defaults
    from harness.registry.choice import choose as choose
    from harness.registry.choice import split_list as split_list
    from harness.registry.given import Given as Given
    from harness.registry.given import given_from_json as given_from_json
    from harness.registry.given import given_to_json as given_to_json
    from harness.registry.given import read_given as read_given
    from harness.registry.given import split_measures as split_measures
    from harness.registry.names import did_you_mean as did_you_mean
    from harness.registry.parameters import build as build
    from harness.registry.parameters import parameters_of as parameters_of
    from harness.registry.registry import Registry as Registry
    from harness.registry.registry import load_registry as load_registry
    from harness.registry.spec import PLANNED as PLANNED
    from harness.registry.spec import blamed_on as blamed_on
    from harness.registry.toml_file import read_toml as read_toml
    from harness.report.figures.chart import Axis as Axis
    from harness.report.figures.chart import Chart as Chart
    from harness.report.figures.chart import Line as Line
    from harness.report.figures.chart import linear_axis as linear_axis
    from harness.report.figures.draw import draw_chart as draw_chart
    from harness.report.figures.points import select_points as select_points
    from harness.report.page.page import render_page as render_page
    from harness.report.page.page import write_page as write_page
    from harness.report.rows.ratios import Grid as Grid
    from harness.report.rows.ratios import format_number as format_number
    from harness.report.tables.grid import show_grid as show_grid
    from harness.results.comparison import Group as Group
    from harness.results.load import read_results as read_results
    from harness.results.load import require_arm as require_arm
    from harness.results.measured import value_of as value_of
    from harness.results.metrics import named_measures as named_measures
    from harness.results.recordings.episodes import episodes_of as episodes_of
    from harness.results.recordings.read_runs import has_recordings as has_recordings
    from harness.reward.needs import needs_of as needs_of
    from harness.robot.ground_clearance import Solids as Solids
    from harness.robot.ground_clearance import build_solids as build_solids
    from harness.score.csv_writing import write_csv as write_csv
    from harness.score.scorer import pay_log as pay_log

_NAMES = {
    "harness.audit.number": ("number",),
    "harness.cli.flags.shared": (
        "ALGORITHMS",
        "AsJson",
        "ExecutorName",
        "ExperimentFolder",
        "Jobs",
        "Measures",
        "PluginFiles",
        "REWARDS",
        "ROBOT",
        "ROBOTS",
        "RewardNames",
        "RobotName",
        "SIMULATORS",
        "TaskName",
    ),
    "harness.cli.interrupted": ("kept_when_interrupted",),
    "harness.cli.output": ("complain", "say", "say_json"),
    "harness.cli.progress": ("LiveProgress",),
    "harness.cli.terminal": ("Terminal", "show"),
    "harness.env.make": ("build_world",),
    "harness.env.solid_probes": ("Probe", "few_points", "find_missing", "missing_in_words", "probes_of"),
    "harness.eta.headline": ("SUCCESS",),
    "harness.eta.index": ("NOTHING",),
    "harness.eta.seed_mean": ("SeedMean", "mean_lost_share", "mean_over_seeds"),
    "harness.experiment.changed": ("changed_cells", "refuse_changed"),
    "harness.experiment.draft": ("draft_of", "leave_record"),
    "harness.experiment.environments.paid_again": ("PayAgain",),
    "harness.experiment.evaluation.evaluator": ("Evaluator",),
    "harness.experiment.experiment": ("DEFAULT_FOLDER", "ExperimentRun"),
    "harness.experiment.plan": (
        "DEFAULT_TASK",
        "Episodes",
        "Names",
        "Plan",
        "Seed",
        "SeedCount",
        "Steps",
        "check_experiment",
        "expand",
    ),
    "harness.experiment.provenance": ("describe_environment",),
    "harness.experiment.run_options": ("RunOptions",),
    "harness.experiment.task_plan": ("table_of",),
    "harness.experiment.watch": ("UNWATCHED",),
    "harness.experiment.workers.order": ("Order", "Report"),
    "harness.experiment.workers.workers": ("News", "run_orders", "worker_count"),
    "harness.experiment.world": ("world_of",),
    "harness.files.bounded": ("digest_of", "read_bytes", "reading"),
    "harness.files.whole_file": ("files_in", "is_partial", "write_whole"),
    "harness.log.log": ("BEHAVIOUR", "REWARD", "episode_rows"),
    "harness.motion.limits": ("JointLimits",),
    "harness.policy.continuous": ("ContinuousNetwork",),
    "harness.policy.folder": ("read_folder",),
    "harness.policy.network": ("MEAN", "STD"),
    "harness.record.cell": ("Cell",),
    "harness.record.cell_folder": ("require_files",),
    "harness.record.episode_facts": ("episode_facts",),
    "harness.record.file_forms": ("ChoiceForm", "EndingForm"),
    "harness.record.folder": (
        "EVALUATION",
        "EVALUATION_RECORDING",
        "MANIFEST",
        "POLICY",
        "TRACE",
        "TRAINING_RECORDING",
        "WEIGHTS",
        "partial_folder",
        "publish",
        "recording_of",
    ),
    "harness.record.manifest": ("Ending", "now", "read_manifest", "read_record"),
    "harness.record.out_folder": ("folder_lock", "make_folder", "refuse_links", "storage_errors"),
    "harness.record.recording.csv_writing": ("write_recording_csv",),
    "harness.record.recording.facts": ("facts_of", "term_column"),
    "harness.record.recording.recorded_training": ("FLAGS", "is_recording", "read_recording", "recordings_in"),
    "harness.record.returns": ("mean_return",),
    "harness.record.store": ("Store",),
    "harness.record.trace": ("read_trace",),
    "harness.recorder.walk": ("Walk",),
    "harness.registry.choice": ("Choice", "build_defaults", "choose", "split_list"),
    "harness.registry.given": ("Given", "given_from_json", "given_to_json", "read_given", "split_measures"),
    "harness.registry.names": ("did_you_mean",),
    "harness.registry.parameters": ("build", "parameters_of"),
    "harness.registry.registry": ("Registry", "load_registry"),
    "harness.registry.spec": ("PLANNED", "blamed_on"),
    "harness.registry.toml_file": ("read_toml",),
    "harness.report.figures.chart": ("Axis", "Chart", "Line", "linear_axis"),
    "harness.report.figures.draw": ("draw_chart",),
    "harness.report.figures.points": ("select_points",),
    "harness.report.page.page": ("render_page", "write_page"),
    "harness.report.rows.ratios": ("Grid", "format_number"),
    "harness.report.tables.grid": ("show_grid",),
    "harness.results.comparison": ("Group",),
    "harness.results.load": ("read_results", "require_arm"),
    "harness.results.measured": ("value_of",),
    "harness.results.metrics": ("named_measures",),
    "harness.results.recordings.episodes": ("episodes_of",),
    "harness.results.recordings.read_runs": ("has_recordings",),
    "harness.reward.needs": ("needs_of",),
    "harness.robot.ground_clearance": ("Solids", "build_solids"),
    "harness.score.csv_writing": ("write_csv",),
    "harness.score.scorer": ("pay_log",),
}
"""The public names of each module."""

__all__ = sorted(name for names in _NAMES.values() for name in names)  # noqa: PLE0605

__getattr__ = lazy_names(__name__, {name: home for home, names in _NAMES.items() for name in names}, {})
