"""``harness list``: what can be named."""

from typing import Annotated

import typer

from harness.errors import UsageError
from harness.hookspecs import KINDS
from harness.registry.registry import conflict, load_registry, unknown_name


def list_names(
    kind: Annotated[
        str | None, typer.Argument(help=f"One of: {', '.join(KINDS)}.", metavar="[KIND]", show_default=False)
    ] = None,
) -> None:
    """List simulators, algorithms, rewards, metrics, robots, tasks, executors and the commands of plugins."""
    if kind is not None and kind not in KINDS:
        raise UsageError(unknown_name("kind", kind, KINDS))
    registry = load_registry()
    for shown in KINDS if kind is None else (kind,):
        typer.echo(f"{shown}:")
        for name in registry.names(shown):
            specs = registry.specs[shown, name]
            note = conflict(specs) if len(specs) > 1 else specs[0].summary
            if specs[0].missing:
                note += f" [missing {', '.join(specs[0].missing)}: {specs[0].remedy}]"
            typer.echo(f"  {name:<18}{note}")
