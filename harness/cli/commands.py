"""Commands that plugins bring."""

import os
from collections.abc import Callable, Collection, Sequence
from typing import Any

import typer
from typer.exceptions import TyperException

from harness.cli.help import PLAIN, Command, epilog_of
from harness.cli.unexpected import describe_fault
from harness.errors import HarnessError, PluginError
from harness.hookspecs import PROJECT
from harness.registry.choice import Registry
from harness.registry.registry import installed, load_registry
from harness.registry.spec import OURS
from harness.text import command_text, visible

KIND = "commands"
PANEL = "From plugins"
OPTION = "--"
"""What stands in the name of an option that a plugin brings for one of our commands, ``report--summary``."""
EXAMPLES = "examples"
"""The attribute of a command's function that holds what one may type, a line each; shown at the end of its help."""
PASS_ON = {"allow_extra_args": True, "ignore_unknown_options": True, "help_option_names": []}
"""Every argument goes to the plugin's function, ``--help`` included."""


def plugins_for(words: Sequence[str]) -> tuple[Registry, str | None]:
    """The plugins that a command line needs, and the one command that it does, where our own plugins bring that.

    Others are not imported then, so `harness check` can say that one ends the process which imports it.
    """
    if words and not words[0].startswith("-"):
        ours = load_registry([point for point in installed(PROJECT) if point.dist and point.dist.name == OURS])
        if words[0] in ours.names(KIND):
            return ours, words[0]
    return load_registry(), None


def add_plugin_commands(app: typer.Typer, registry: Registry, own: Collection[str]) -> None:
    """Add the commands of plugins, by name and summary alone; a name of ours, of `own`, stays ours.

    A name that several claim is there too: calling it tells the qualified names.
    """
    specs = [spec for spec in registry.all_specs() if spec.kind == KIND]
    claimed = {spec.name for spec in specs} - set(own)
    qualified = {spec.qualified for spec in specs if spec.name in own}
    for name in sorted({*registry.names(KIND), *claimed, *qualified} - set(own)):
        if OPTION in name and name.partition(OPTION)[0] in {*own, *registry.names(KIND)}:
            continue
        if name in _words_to_complete() and name in registry.names(KIND):
            app.command(name, rich_help_panel=_panel_of(registry, name))(registry.get(KIND, name).load())
            continue
        help_line = visible(_summary_of(registry, name), keep="\n")
        app.command(name, help=help_line, rich_help_panel=_panel_of(registry, name), context_settings=PASS_ON)(
            _called(registry, name)
        )


def _words_to_complete() -> list[str]:
    """The words of the line that a shell wants to complete; none where no shell asks. It needs the flags themselves."""
    asked = any(name.endswith("_COMPLETE") for name in os.environ)
    told = (os.environ.get(name, "") for name in ("COMP_WORDS", "_TYPER_COMPLETE_ARGS"))
    return [word for line in told for word in line.split()] if asked else []


def hidden_commands(registry: Registry, own: Collection[str]) -> list[str]:
    """One line for each command of a plugin that cannot be called: one of ours has its name.

    Args:
        registry: The plugins.
        own: Names of our commands: what `harness.cli.app.main` hands every command as the object of its context.
    """
    return [
        f"Command '{spec.name}' of the plugin '{spec.plugin}' ({spec.package}) is hidden by a built-in command: "
        f"type {command_text('harness', spec.qualified)}"
        for spec in registry.all_specs()
        if spec.kind == KIND and spec.name in own
    ]


def _summary_of(registry: Registry, name: str) -> str:
    try:
        return registry.get(KIND, name).summary
    except PluginError as error:  # several claim it
        return str(error)


def _panel_of(registry: Registry, name: str) -> str:
    return (registry.get(KIND, name).heading if name in registry.names(KIND) else "") or PANEL


def _called(registry: Registry, name: str) -> Callable[[typer.Context], Any]:
    """A command that imports the one of that name when it is called, and hands it all arguments."""

    def command(context: typer.Context) -> Any:
        one = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
        spec = registry.get(KIND, name)
        function = spec.load()
        examples: tuple[str, ...] = getattr(function, EXAMPLES, ())
        epilog = epilog_of(examples) if examples else None
        one.command(name, cls=Command, epilog=epilog, context_settings=dict(PLAIN))(function)
        try:
            loaded = typer.main.get_command(one)
            return loaded.main(context.args, prog_name=f"harness {name}", standalone_mode=False, obj=context.obj)
        except (HarnessError, TyperException, OSError, typer.Abort, typer.Exit):
            raise
        except Exception as error:  # whose fault it is that something else passes
            raise PluginError(describe_fault(spec.title, error)) from error

    return command
