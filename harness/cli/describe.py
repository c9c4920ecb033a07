"""``harness describe``: all names listed, or one explained."""

from typing import Annotated

import typer

from harness.cli.flags.shared import ROBOTS, PluginFiles, names_of
from harness.cli.output import say
from harness.errors import UsageError
from harness.hookspecs import KINDS


def describe(
    name: Annotated[
        str | None,
        typer.Argument(
            help="A name such as arp:k2=2, the path of a URDF, or a kind of names, such as rewards.",
            show_default="every name is listed",
            autocompletion=names_of(*KINDS),
        ),
    ] = None,
    robot: Annotated[
        str | None,
        typer.Option(
            help="The robot that a task is described for; alone it is described itself.",
            show_default="the task's",
            metavar="NAME",
            autocompletion=ROBOTS,
        ),
    ] = None,
    plugin: PluginFiles = None,
) -> None:
    """List every name that can be typed, or explain one.

    A reward, a task, an algorithm or any other plugin is explained with its parameters.
    """
    from harness.registry.given import read_given
    from harness.registry.registry import load_registry

    registry = load_registry(given=read_given(plugin))
    if (name is None and robot is None) or (name in KINDS and not registry.kinds_of(name)):
        from harness.cli.names import list_names

        list_names(registry, name)
        return
    from harness.describe import describe_name  # it imports what a list does not need
    from harness.registry.choice import parse
    from harness.registry.spec import unknown_name
    from harness.robot.robot import is_folder, is_path

    if name is None:
        say(describe_name(registry, "robots", str(robot), None))
        return
    kinds = registry.kinds_of(name.partition(":")[0]) or (["robots"] if is_path(name) or is_folder(name) else [])
    if not kinds:
        asked = parse(name)[0]
        raise UsageError(
            unknown_name("name", asked, [*registry.all_names(), *KINDS]) + registry.not_loaded("rewards", asked)
        )
    say("\n\n".join(describe_name(registry, kind, name, robot) for kind in kinds))
