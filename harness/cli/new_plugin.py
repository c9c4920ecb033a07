"""``harness new-plugin``: a package that works, for its author to change."""

from pathlib import Path
from typing import Annotated

import typer

from harness.cli.output import say
from harness.errors import UsageError
from harness.text import command_text

NEXT = """{folder}: {count} files. Type next:

  {install}
  {test}
  {command}

The {noun} is {folder}/{module}/{kind}.py: change that file, and its tests beside it."""


def _kinds(incomplete: str) -> list[str]:
    """What a shell offers."""
    from harness.scaffold.package import kinds

    return [kind for kind in kinds() if kind.startswith(incomplete)]


def new_plugin(
    context: typer.Context,
    kind: Annotated[
        str,
        typer.Argument(
            help="algorithm, command, environment, executor, log, metric, reward, robot, simulator, task or tracker.",
            autocompletion=_kinds,
            metavar="KIND",
        ),
    ],
    name: Annotated[str, typer.Argument(help="The name that users will type, such as my-reward.", metavar="NAME")],
    into: Annotated[
        Path, typer.Option(help="The folder that the new package is made in.", show_default="here", metavar="DIR")
    ] = Path(),
) -> None:
    """Write a plugin's package: a working implementation, its tests, a README and a CI workflow."""
    from harness.hookspecs import NOUNS
    from harness.registry.registry import load_registry
    from harness.scaffold.package import (
        command_to_try,
        package_files,
        plural_of,
        require_new,
        require_unclaimed,
        write_package,
    )
    from harness.scaffold.plugin_name import PluginName

    folder = into / name
    require_new(folder)
    plugin = PluginName(name)
    files = package_files(kind, plugin)
    require_unclaimed(kind, plugin, load_registry())
    if kind == "command" and name in context.obj:
        raise UsageError(f"The name '{name}' is taken: it is a command of the harness. Choose another name")
    write_package(files, folder)
    install, test = command_text("pip", "install", "-e", Path(f"{folder}[test]")), command_text("pytest", folder)
    command = command_to_try(kind, plugin)
    noun = NOUNS[plural_of(kind)]
    told = NEXT.format(
        folder=folder,
        count=len(files),
        install=install,
        test=test,
        command=command,
        noun=noun,
        kind=kind,
        module=plugin.module,
    )
    say(told)
