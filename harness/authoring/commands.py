"""What commands are written with: flags, output, an experiment's folder, runs, pages. Commands of our own use it too.

Every name is looked up when it is first used, so that importing this module imports nothing heavy.
"""

# ruff: noqa: PLC0414 -- `X as X` tells type checkers that the name is public

from typing import TYPE_CHECKING

from harness.authoring.face import lazy_names

if TYPE_CHECKING:
    from harness.cli.flags.shared import ROBOT as ROBOT
    from harness.cli.flags.shared import AsJson as AsJson
    from harness.cli.flags.shared import PluginFiles as PluginFiles
    from harness.cli.output import complain as complain
    from harness.cli.output import say as say
    from harness.cli.output import say_json as say_json
    from harness.env.solid_probes import find_missing as find_missing
    from harness.env.solid_probes import missing_in_words as missing_in_words
    from harness.env.solid_probes import probes_of as probes_of
    from harness.experiment.plan import check_experiment as check_experiment
    from harness.experiment.plan import expand as expand
    from harness.experiment.workers.order import Order as Order
    from harness.experiment.workers.order import Report as Report
    from harness.experiment.workers.workers import News as News
    from harness.files.whole_file import write_whole as write_whole
    from harness.record.cell import Cell as Cell
    from harness.record.folder import partial_folder as partial_folder
    from harness.record.manifest import Manifest as Manifest
    from harness.record.manifest import read_manifest as read_manifest
    from harness.registry.choice import Choice as Choice
    from harness.registry.choice import choose as choose
    from harness.registry.choice import parse as parse
    from harness.registry.given import Given as Given
    from harness.registry.given import read_given as read_given
    from harness.registry.names import unknown_name as unknown_name
    from harness.registry.registry import Registry as Registry
    from harness.registry.registry import load_registry as load_registry

_NAMES = {
    "harness.cli.flags.shared": ("AsJson", "PluginFiles", "ROBOT"),
    "harness.cli.output": ("complain", "say", "say_json"),
    "harness.env.solid_probes": ("find_missing", "missing_in_words", "probes_of"),
    "harness.experiment.plan": ("check_experiment", "expand"),
    "harness.experiment.workers.order": ("Order", "Report"),
    "harness.experiment.workers.workers": ("News",),
    "harness.files.whole_file": ("write_whole",),
    "harness.record.cell": ("Cell",),
    "harness.record.folder": ("partial_folder",),
    "harness.record.manifest": ("Manifest", "read_manifest"),
    "harness.registry.choice": ("Choice", "choose", "parse"),
    "harness.registry.given": ("Given", "read_given"),
    "harness.registry.names": ("unknown_name",),
    "harness.registry.registry": ("Registry", "load_registry"),
}
"""The public names of each module."""

__all__ = sorted(name for names in _NAMES.values() for name in names)  # noqa: PLE0605

__getattr__ = lazy_names(__name__, {name: home for home, names in _NAMES.items() for name in names}, {})
