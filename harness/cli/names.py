"""``harness list``: what can be named."""

from typing import Annotated

import typer

from harness.cli.flags.shared import PluginFiles
from harness.cli.output import complain, say
from harness.errors import UsageError
from harness.hookspecs import KINDS
from harness.registry.given import read_given
from harness.registry.names import unknown_name
from harness.registry.registry import load_registry


def list_names(
    kind: Annotated[
        str | None, typer.Argument(help=f"One of: {', '.join(KINDS)}.", metavar="[KIND]", show_default=False)
    ] = None,
    plugin: PluginFiles = None,
) -> None:
    """List all simulators, algorithms, rewards, metrics, robots, tasks and other plugins."""
    if kind is not None and kind not in KINDS:
        raise UsageError(unknown_name("kind", kind, KINDS))
    registry = load_registry(given=read_given(plugin))
    for shown in KINDS if kind is None else (kind,):
        say(f"{shown}:")
        width = max(16, *map(len, registry.names(shown)), 0) + 2
        for name in registry.names(shown):
            spec = registry.get(shown, name)
            note = f" [missing {', '.join(spec.missing)}: {spec.remedy}]" if spec.missing else ""
            say(f"  {name:<{width}}{spec.summary}{note}")
    for line in registry.complaints():
        complain(line)
