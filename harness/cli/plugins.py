"""``harness plugins``: who registered what."""

from dataclasses import asdict
from typing import Annotated

import typer

from harness.cli.commands import hidden_commands
from harness.cli.flags.shared import AsJson
from harness.cli.output import say, say_json
from harness.registry.registry import load_registry
from harness.registry.targets import examined, why_unfit


def plugins(
    context: typer.Context,
    check: Annotated[
        bool,
        typer.Option(
            "--check", help="Also import everything that plugins registered. Ends with status 1 if a plugin is broken."
        ),
    ] = False,
    as_json: AsJson = False,
) -> int:
    """Show every plugin, where it comes from, what it registered, and what is wrong with it."""
    registry = load_registry()
    found = examined(registry, why_unfit) if check else examined(registry)
    status = 1 if check and any(plugin.is_at_fault for plugin in found) else 0
    conflicts = registry.conflicts() + hidden_commands(registry, context.obj) + registry.notes
    if as_json:
        shown = {"plugins": [asdict(plugin) for plugin in found], "conflicts": conflicts}
        say_json(shown)
        return status
    for plugin in found:
        say(f"{plugin.name}  {plugin.status}  {plugin.distribution} {plugin.version}  ({plugin.module})")
        say(f"  {plugin.reason or ', '.join(plugin.registered) or 'registers nothing'}")
        if plugin.own:
            say(f"  the file's own, no rewards: {', '.join(plugin.own)}")
        for remark in plugin.remarks:
            say(f"  {remark}")
    for line in conflicts:
        say(f"conflict: {line}")
    return status
