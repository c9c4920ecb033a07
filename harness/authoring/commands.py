"""What commands are written with: flags, output, an experiment's folder, runs, pages. Commands of our own use it too.

Every name is looked up when it is first used, so that importing this module imports nothing heavy.
"""

# ruff: noqa: PLC0414 -- `X as X` tells type checkers that the name is public

from typing import TYPE_CHECKING

from harness.authoring.face import lazy_names

if TYPE_CHECKING:
    from harness.cli.commands import hidden_commands as hidden_commands
    from harness.cli.flags.shared import ExperimentFolder as ExperimentFolder
    from harness.cli.flags.shared import PluginFiles as PluginFiles
    from harness.cli.output import complain as complain
    from harness.cli.output import say as say
    from harness.cli.runnable import example_run as example_run
    from harness.cli.runnable import usable as usable
    from harness.cli.unexpected import describe_unexpected as describe_unexpected
    from harness.experiment.provenance import CHECKOUT as CHECKOUT
    from harness.experiment.provenance import describe_machine as describe_machine
    from harness.experiment.provenance import source_commit as source_commit
    from harness.experiment.provenance import versions_behind as versions_behind
    from harness.files.bounded import parse_json as parse_json
    from harness.files.bounded import read_bytes as read_bytes
    from harness.files.bounded import read_json as read_json
    from harness.files.bounded import reading as reading
    from harness.files.bounded import require_regular as require_regular
    from harness.record.dataset.labels import UNKNOWN as UNKNOWN
    from harness.record.dataset.labels import SuccessRule as SuccessRule
    from harness.record.dataset.labels import parse_success as parse_success
    from harness.record.dataset.open_dataset import MOST_EPISODES as MOST_EPISODES
    from harness.registry.choice import choose as choose
    from harness.registry.libraries import is_met as is_met
    from harness.registry.names import did_you_mean as did_you_mean
    from harness.registry.registry import Registry as Registry
    from harness.registry.registry import load_registry as load_registry
    from harness.registry.spec import OURS as OURS
    from harness.registry.targets import examined as examined
    from harness.report.page.page import render_page as render_page
    from harness.report.replay.section import replay_of as replay_of
    from harness.report.rows.comparison import question as question
    from harness.results.overview import line_names as line_names
    from harness.results.overview import overview_of as overview_of
    from harness.results.overview import overview_row as overview_row
    from harness.results.replay import shows_of as shows_of

_NAMES = {
    "harness.cli.commands": ("hidden_commands",),
    "harness.cli.flags.shared": (
        "ExperimentFolder",
        "PluginFiles",
    ),
    "harness.cli.output": (
        "complain",
        "say",
    ),
    "harness.cli.runnable": (
        "example_run",
        "usable",
    ),
    "harness.cli.unexpected": ("describe_unexpected",),
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
    "harness.record.dataset.labels": (
        "SuccessRule",
        "UNKNOWN",
        "parse_success",
    ),
    "harness.record.dataset.open_dataset": ("MOST_EPISODES",),
    "harness.registry.choice": ("choose",),
    "harness.registry.libraries": ("is_met",),
    "harness.registry.names": ("did_you_mean",),
    "harness.registry.registry": (
        "Registry",
        "load_registry",
    ),
    "harness.registry.spec": ("OURS",),
    "harness.registry.targets": ("examined",),
    "harness.report.page.page": ("render_page",),
    "harness.report.replay.section": ("replay_of",),
    "harness.report.rows.comparison": ("question",),
    "harness.results.overview": (
        "line_names",
        "overview_of",
        "overview_row",
    ),
    "harness.results.replay": ("shows_of",),
}
"""The public names of each module."""

__all__ = sorted(name for names in _NAMES.values() for name in names)  # noqa: PLE0605

__getattr__ = lazy_names(__name__, {name: home for home, names in _NAMES.items() for name in names}, {})
