"""``harness describe``: one name explained."""

from typing import Annotated

import typer

from harness.cli.completion import names_of
from harness.cli.lines import say
from harness.cli.options import ROBOTS
from harness.errors import UsageError
from harness.hookspecs import KINDS


def describe(
    name: Annotated[
        str,
        typer.Argument(
            help="Anything that `harness list` shows, as arp or arp:k2=2; or a URDF.", autocompletion=names_of(*KINDS)
        ),
    ],
    robot: Annotated[
        str | None,
        typer.Option(
            help="The robot that a task is described for.",
            show_default="the task's",
            metavar="NAME",
            autocompletion=ROBOTS,
        ),
    ] = None,
) -> None:
    """Explain a task, reward, simulator, algorithm, metric or robot, with its parameters."""
    from harness.describe import describe_name
    from harness.registry.choice import parse
    from harness.registry.registry import load_registry, unknown_name
    from harness.robot.load import is_path

    registry = load_registry()
    bare = name if is_path(name) else parse(name)[0]
    kinds = ["robots"] if is_path(name) else [kind for kind in KINDS if (kind, bare) in registry.specs]
    if not kinds:
        raise UsageError(unknown_name("name", bare, {known for _, known in registry.specs}))
    say("\n\n".join(describe_name(registry, kind, name, robot) for kind in kinds))
