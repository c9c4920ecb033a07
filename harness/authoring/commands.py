"""What commands are written with: flags, output, an experiment's folder, runs, pages. Commands of our own use it too.

Every name is looked up when it is first used, so that importing this module imports nothing heavy.
"""

# ruff: noqa: PLC0414 -- `X as X` tells type checkers that the name is public

from typing import TYPE_CHECKING

from harness.authoring.face import lazy_names

if TYPE_CHECKING:
    from harness.cli.flags.shared import PluginFiles as PluginFiles
    from harness.cli.output import complain as complain
    from harness.cli.output import say as say

_NAMES = {
    "harness.cli.flags.shared": ("PluginFiles",),
    "harness.cli.output": ("complain", "say"),
}
"""The public names of each module."""

__all__ = sorted(name for names in _NAMES.values() for name in names)  # noqa: PLE0605

__getattr__ = lazy_names(__name__, {name: home for home, names in _NAMES.items() for name in names}, {})
