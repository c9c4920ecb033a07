"""``harness describe``: one name explained."""

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
            help="A name that `harness list` shows, such as arp or arp:k2=2, or the path of a URDF.",
            show_default="that of --robot",
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
    """Explain a reward, a task, an algorithm or any other plugin. It shows the parameters too."""
    from harness.describe import describe_name
    from harness.registry.choice import parse
    from harness.registry.given import read_given
    from harness.registry.names import unknown_name
    from harness.registry.registry import load_registry
    from harness.robot.robot import is_folder, is_path

    registry = load_registry(given=read_given(plugin))
    if name is None:
        if robot is None:
            raise UsageError("Nothing to describe: give a name that harness list shows, or --robot and a URDF.")
        say(describe_name(registry, "robots", robot, None))
        return
    kinds = registry.kinds_of(name.partition(":")[0]) or (["robots"] if is_path(name) or is_folder(name) else [])
    if not kinds:
        asked = parse(name)[0]
        raise UsageError(unknown_name("name", asked, registry.all_names()) + registry.not_loaded("rewards", asked))
    say("\n\n".join(describe_name(registry, kind, name, robot) for kind in kinds))
