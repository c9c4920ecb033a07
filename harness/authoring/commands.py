"""What commands are written with: flags, output, an experiment's folder, runs, pages. Commands of our own use it too.

Every name is looked up when it is first used, so that importing this module imports nothing heavy.
"""

# ruff: noqa: PLC0414 -- `X as X` tells type checkers that the name is public

from typing import TYPE_CHECKING

from harness.authoring.face import lazy_names

if TYPE_CHECKING:
    from harness.authoring.face import lazy_names as lazy_names
    from harness.cli.audits import audits_of as audits_of
    from harness.cli.commands import hidden_commands as hidden_commands
    from harness.cli.completion import names_of as names_of
    from harness.cli.datasets import names_dataset as names_dataset
    from harness.cli.flags.dataset import Partial as Partial
    from harness.cli.flags.dataset import Places as Places
    from harness.cli.flags.logs import AsFormat as AsFormat
    from harness.cli.flags.logs import SortBy as SortBy
    from harness.cli.flags.shared import REWARDS as REWARDS
    from harness.cli.flags.shared import SIMULATORS as SIMULATORS
    from harness.cli.flags.shared import AsJson as AsJson
    from harness.cli.flags.shared import ExperimentFolder as ExperimentFolder
    from harness.cli.flags.shared import PluginFiles as PluginFiles
    from harness.cli.flags.shared import RobotName as RobotName
    from harness.cli.flags.shared import TaskName as TaskName
    from harness.cli.output import complain as complain
    from harness.cli.output import say as say
    from harness.cli.output import say_json as say_json
    from harness.cli.runnable import example_run as example_run
    from harness.cli.runnable import usable as usable
    from harness.cli.terminal import show as show
    from harness.cli.unexpected import describe_unexpected as describe_unexpected
    from harness.env.ideal import IdealSimulator as IdealSimulator
    from harness.eta.auc import AGAINST as AGAINST
    from harness.eta.auc import CANNOT_TELL as CANNOT_TELL
    from harness.eta.auc import RANKS as RANKS
    from harness.eta.auc import Auc as Auc
    from harness.eta.auc import auc_of as auc_of
    from harness.eta.auc import rounded as rounded
    from harness.eta.clustered_share import share_of as share_of
    from harness.eta.headline import SUCCESS as SUCCESS
    from harness.eta.interval import SHARE as SHARE
    from harness.eta.rescaling import PayLine as PayLine
    from harness.eta.rescaling import Rescaling as Rescaling
    from harness.eta.rescaling import line_of as line_of
    from harness.eta.rescaling import rescaling_of as rescaling_of
    from harness.eta.seed_mean import SeedMean as SeedMean
    from harness.eta.seed_mean import mean_over_seeds as mean_over_seeds
    from harness.experiment.environments.columns import columns_of as columns_of
    from harness.experiment.environments.columns import weighing as weighing
    from harness.experiment.environments.plan import kind_of_task as kind_of_task
    from harness.experiment.environments.plan import look_at as look_at
    from harness.experiment.environments.plan import require_known as require_known
    from harness.experiment.provenance import CHECKOUT as CHECKOUT
    from harness.experiment.provenance import describe_machine as describe_machine
    from harness.experiment.provenance import source_commit as source_commit
    from harness.experiment.provenance import versions_behind as versions_behind
    from harness.files.bounded import parse_json as parse_json
    from harness.files.bounded import read_bytes as read_bytes
    from harness.files.bounded import read_json as read_json
    from harness.files.bounded import reading as reading
    from harness.files.bounded import require_regular as require_regular
    from harness.log.open_log import Found as Found
    from harness.log.open_log import find_logs as find_logs
    from harness.payoff.dataset.arm_pay import places_of as places_of
    from harness.payoff.dataset.paid_dataset import Labels as Labels
    from harness.payoff.dataset.paid_dataset import PaidDataset as PaidDataset
    from harness.payoff.dataset.paid_dataset import pay_dataset as pay_dataset
    from harness.payoff.dataset.rewards import given_rewards as given_rewards
    from harness.payoff.dataset.rewards import rewards_of as rewards_of
    from harness.payoff.dataset.steps import Payer as Payer
    from harness.payoff.finishing import Finishing as Finishing
    from harness.payoff.finishing import Payoff as Payoff
    from harness.payoff.finishing import finishing_of as finishing_of
    from harness.payoff.finishing import on_finishing as on_finishing
    from harness.payoff.finishing import on_terms as on_terms
    from harness.payoff.rollout import CREEP as CREEP
    from harness.payoff.rollout import FINISH as FINISH
    from harness.payoff.rollout import HOLD as HOLD
    from harness.payoff.rollout import HOVER as HOVER
    from harness.payoff.rollout import Rollout as Rollout
    from harness.payoff.rollout import States as States
    from harness.payoff.rollout import record_rollouts as record_rollouts
    from harness.payoff.score import Score as Score
    from harness.payoff.score import discounted_sum as discounted_sum
    from harness.payoff.score import paid_along as paid_along
    from harness.payoff.score import pay_along as pay_along
    from harness.payoff.score import pay_distances as pay_distances
    from harness.payoff.score import score_rollout as score_rollout
    from harness.record.cell import Cell as Cell
    from harness.record.dataset.labels import UNKNOWN as UNKNOWN
    from harness.record.dataset.labels import SuccessRule as SuccessRule
    from harness.record.dataset.labels import parse_success as parse_success
    from harness.record.dataset.labels import read_labels as read_labels
    from harness.record.dataset.open_dataset import MOST_EPISODES as MOST_EPISODES
    from harness.record.dataset.open_dataset import DatasetFacts as DatasetFacts
    from harness.record.dataset.open_dataset import dataset_facts as dataset_facts
    from harness.record.dataset.open_dataset import open_dataset as open_dataset
    from harness.record.folder import TRACE as TRACE
    from harness.record.recording.facts import facts_of as facts_of
    from harness.record.recording.recorded_training import read_recording as read_recording
    from harness.record.store import Store as Store
    from harness.record.trace import read_trace as read_trace
    from harness.recorder.column import made_columns as made_columns
    from harness.recorder.guard import Guard as Guard
    from harness.recorder.record_rewards import RecordRewards as RecordRewards
    from harness.recorder.recorder import differs as differs
    from harness.recorder.walk import KeepWalks as KeepWalks
    from harness.recorder.walk import Walk as Walk
    from harness.registry.choice import Choice as Choice
    from harness.registry.choice import choose as choose
    from harness.registry.choice import split_list as split_list
    from harness.registry.given import read_given as read_given
    from harness.registry.libraries import is_met as is_met
    from harness.registry.names import did_you_mean as did_you_mean
    from harness.registry.names import unknown_name as unknown_name
    from harness.registry.registry import Registry as Registry
    from harness.registry.registry import load_registry as load_registry
    from harness.registry.spec import OURS as OURS
    from harness.registry.spec import blamed_on as blamed_on
    from harness.registry.targets import examined as examined
    from harness.report.figures.chart import Chart as Chart
    from harness.report.figures.chart import Line as Line
    from harness.report.figures.chart import linear_axis as linear_axis
    from harness.report.figures.draw import draw_chart as draw_chart
    from harness.report.page.page import render_page as render_page
    from harness.report.page.page import write_page as write_page
    from harness.report.replay.section import replay_of as replay_of
    from harness.report.rows.comparison import question as question
    from harness.report.rows.ratios import Grid as Grid
    from harness.results.load import read_results as read_results
    from harness.results.logs.checks import facts_notes as facts_notes
    from harness.results.logs.checks import require_comparable as require_comparable
    from harness.results.logs.checks import without_short as without_short
    from harness.results.logs.read_logs import read_trainings as read_trainings
    from harness.results.logs.trainings import sort_logs as sort_logs
    from harness.results.overview import line_names as line_names
    from harness.results.overview import overview_of as overview_of
    from harness.results.overview import overview_row as overview_row
    from harness.results.recordings.episodes import Episodes as Episodes
    from harness.results.recordings.episodes import Part as Part
    from harness.results.recordings.episodes import count_text as count_text
    from harness.results.recordings.episodes import episodes_of as episodes_of
    from harness.results.recordings.read_runs import env_of as env_of
    from harness.results.recordings.read_runs import has_recordings as has_recordings
    from harness.results.recordings.read_runs import read_all as read_all
    from harness.results.recordings.read_runs import whole_runs as whole_runs
    from harness.results.recordings.results import RecordedResults as RecordedResults
    from harness.results.recordings.runs import LAST_SHARE as LAST_SHARE
    from harness.results.recordings.runs import NO_NAME as NO_NAME
    from harness.results.recordings.runs import RANDOM as RANDOM
    from harness.results.recordings.runs import Run as Run
    from harness.results.replay import shows_of as shows_of
    from harness.reward.given import FIELDS as FIELDS
    from harness.reward.given import OWN as OWN
    from harness.reward.steps import BEFORE as BEFORE
    from harness.reward.steps import DISTANCE as DISTANCE
    from harness.reward.steps import rows_of as rows_of
    from harness.reward.steps import step_between as step_between
    from harness.reward.steps import steps_type as steps_type
    from harness.robot.load import load_robot as load_robot
    from harness.score.installed_reward import InstalledReward as InstalledReward
    from harness.score.places import ArmPlaces as ArmPlaces

_NAMES = {
    "harness.authoring.face": ("lazy_names",),
    "harness.cli.audits": ("audits_of",),
    "harness.cli.commands": ("hidden_commands",),
    "harness.cli.completion": ("names_of",),
    "harness.cli.datasets": ("names_dataset",),
    "harness.cli.flags.dataset": (
        "Partial",
        "Places",
    ),
    "harness.cli.flags.logs": (
        "AsFormat",
        "SortBy",
    ),
    "harness.cli.flags.shared": (
        "AsJson",
        "ExperimentFolder",
        "PluginFiles",
        "REWARDS",
        "RobotName",
        "SIMULATORS",
        "TaskName",
    ),
    "harness.cli.output": (
        "complain",
        "say",
        "say_json",
    ),
    "harness.cli.runnable": (
        "example_run",
        "usable",
    ),
    "harness.cli.terminal": ("show",),
    "harness.cli.unexpected": ("describe_unexpected",),
    "harness.env.ideal": ("IdealSimulator",),
    "harness.eta.auc": (
        "AGAINST",
        "Auc",
        "CANNOT_TELL",
        "RANKS",
        "auc_of",
        "rounded",
    ),
    "harness.eta.clustered_share": ("share_of",),
    "harness.eta.headline": ("SUCCESS",),
    "harness.eta.interval": ("SHARE",),
    "harness.eta.rescaling": (
        "PayLine",
        "Rescaling",
        "line_of",
        "rescaling_of",
    ),
    "harness.eta.seed_mean": (
        "SeedMean",
        "mean_over_seeds",
    ),
    "harness.experiment.environments.columns": (
        "columns_of",
        "weighing",
    ),
    "harness.experiment.environments.plan": (
        "kind_of_task",
        "look_at",
        "require_known",
    ),
    "harness.experiment.provenance": (
        "CHECKOUT",
        "describe_machine",
        "source_commit",
        "versions_behind",
    ),
    "harness.files.bounded": (
        "parse_json",
        "read_bytes",
        "read_json",
        "reading",
        "require_regular",
    ),
    "harness.log.open_log": (
        "Found",
        "find_logs",
    ),
    "harness.payoff.dataset.arm_pay": ("places_of",),
    "harness.payoff.dataset.paid_dataset": (
        "Labels",
        "PaidDataset",
        "pay_dataset",
    ),
    "harness.payoff.dataset.rewards": (
        "given_rewards",
        "rewards_of",
    ),
    "harness.payoff.dataset.steps": ("Payer",),
    "harness.payoff.finishing": (
        "Finishing",
        "Payoff",
        "finishing_of",
        "on_finishing",
        "on_terms",
    ),
    "harness.payoff.rollout": (
        "CREEP",
        "FINISH",
        "HOLD",
        "HOVER",
        "Rollout",
        "States",
        "record_rollouts",
    ),
    "harness.payoff.score": (
        "Score",
        "discounted_sum",
        "paid_along",
        "pay_along",
        "pay_distances",
        "score_rollout",
    ),
    "harness.record.cell": ("Cell",),
    "harness.record.dataset.labels": (
        "SuccessRule",
        "UNKNOWN",
        "parse_success",
        "read_labels",
    ),
    "harness.record.dataset.open_dataset": (
        "DatasetFacts",
        "MOST_EPISODES",
        "dataset_facts",
        "open_dataset",
    ),
    "harness.record.folder": ("TRACE",),
    "harness.record.recording.facts": ("facts_of",),
    "harness.record.recording.recorded_training": ("read_recording",),
    "harness.record.store": ("Store",),
    "harness.record.trace": ("read_trace",),
    "harness.recorder.column": ("made_columns",),
    "harness.recorder.guard": ("Guard",),
    "harness.recorder.record_rewards": ("RecordRewards",),
    "harness.recorder.recorder": ("differs",),
    "harness.recorder.walk": (
        "KeepWalks",
        "Walk",
    ),
    "harness.registry.choice": (
        "Choice",
        "choose",
        "split_list",
    ),
    "harness.registry.given": ("read_given",),
    "harness.registry.libraries": ("is_met",),
    "harness.registry.names": (
        "did_you_mean",
        "unknown_name",
    ),
    "harness.registry.registry": (
        "Registry",
        "load_registry",
    ),
    "harness.registry.spec": (
        "OURS",
        "blamed_on",
    ),
    "harness.registry.targets": ("examined",),
    "harness.report.figures.chart": (
        "Chart",
        "Line",
        "linear_axis",
    ),
    "harness.report.figures.draw": ("draw_chart",),
    "harness.report.page.page": (
        "render_page",
        "write_page",
    ),
    "harness.report.replay.section": ("replay_of",),
    "harness.report.rows.comparison": ("question",),
    "harness.report.rows.ratios": ("Grid",),
    "harness.results.load": ("read_results",),
    "harness.results.logs.checks": (
        "facts_notes",
        "require_comparable",
        "without_short",
    ),
    "harness.results.logs.read_logs": ("read_trainings",),
    "harness.results.logs.trainings": ("sort_logs",),
    "harness.results.overview": (
        "line_names",
        "overview_of",
        "overview_row",
    ),
    "harness.results.recordings.episodes": (
        "Episodes",
        "Part",
        "count_text",
        "episodes_of",
    ),
    "harness.results.recordings.read_runs": (
        "env_of",
        "has_recordings",
        "read_all",
        "whole_runs",
    ),
    "harness.results.recordings.results": ("RecordedResults",),
    "harness.results.recordings.runs": (
        "LAST_SHARE",
        "NO_NAME",
        "RANDOM",
        "Run",
    ),
    "harness.results.replay": ("shows_of",),
    "harness.reward.given": (
        "FIELDS",
        "OWN",
    ),
    "harness.reward.steps": (
        "BEFORE",
        "DISTANCE",
        "rows_of",
        "step_between",
        "steps_type",
    ),
    "harness.robot.load": ("load_robot",),
    "harness.score.installed_reward": ("InstalledReward",),
    "harness.score.places": ("ArmPlaces",),
}
"""The public names of each module."""

__all__ = sorted(name for names in _NAMES.values() for name in names)  # noqa: PLE0605

__getattr__ = lazy_names(__name__, {name: home for home, names in _NAMES.items() for name in names}, {})
