"""All commands together, and what becomes of their errors."""

import errno
import os
import sys
from collections.abc import Mapping, Sequence
from importlib import import_module
from types import MappingProxyType

import typer
from typer.exceptions import TyperException

from harness.cli.help import EXAMPLES, FIRST_STEPS, PLAIN, All, Command, Commands, LongCommand, epilog_of, meant_flag
from harness.cli.output import complain, libraries_visible, say
from harness.errors import HarnessError, UsageError
from harness.registry.allowed import allow_imports, allow_programs, allow_typed

FAILED, USAGE = 1, 2
ALLOW, ALLOW_PROGRAM = "--allow-import", "--allow-program"
PANELS: Mapping[str, Sequence[str]] = MappingProxyType(
    {
        "Run and read": ("demo", "run", "choose", "report", "status", "describe"),
        "Ask more": ("eta", "score"),
        "Keep results": ("merge", "verify"),
    }
)
"""Every command by the heading that it stands under in ``harness --all``: what one needs first comes first.

It is the function of its name, in the module of that name in `harness.cli`.
"""
LONG = ("run", "choose")
"""The commands that show the options which people type, and all with ``--help-all``."""
UNFORESEEN = 70
"""The exit status after an error that nobody foresaw, EX_SOFTWARE of sysexits.h."""
LONG_NAME = (
    "a path that was given is too long: most systems take names of 255 bytes, and paths of 4,096. Give a shorter one"
)
NO_TEXT = "a name or path that was given is not written in UTF-8, which this needs: give another"


def _show_version(wanted: bool) -> None:
    if wanted:
        import harness

        say(harness.__version__)
        raise typer.Exit


def _root(
    version: bool = typer.Option(False, "--version", help="Show the version.", callback=_show_version, is_eager=True),
    allow_import: str = typer.Option(
        "",
        ALLOW,
        metavar="MODULE",
        help="With any command: let the id of an environment in a file or folder, as MODULE:Name-v0, import MODULE.",
    ),
    allow_program: str = typer.Option(
        "",
        ALLOW_PROGRAM,
        metavar="PATH",
        help="With any command: let an environment in a file or folder start the program PATH.",
    ),
    whole: All = False,
) -> None:
    """Does a reward make a robot behave better, or only the numbers bigger?"""


def build_app(only: str | None = None) -> typer.Typer:
    """The command line without what plugins bring.

    Args:
        only: The command that is called, ours or a plugin's: the options of the others are not put together. None: all
            commands.
    """
    app = typer.Typer(cls=Commands, rich_markup_mode=None, pretty_exceptions_enable=False)
    app.callback(epilog=epilog_of(FIRST_STEPS, "First steps:"), context_settings=dict(PLAIN))(_root)
    for panel, commands in PANELS.items():
        for name in commands:
            if only not in {None, name}:
                continue
            # eta takes more arguments, to say what a pattern without quotes becomes
            settings = {"allow_extra_args": name == "eta", **PLAIN}
            kind, examples = LongCommand if name in LONG else Command, epilog_of(EXAMPLES[name])
            function = getattr(import_module(f"harness.cli.{name}"), name)  # no other command is imported
            app.command(name, cls=kind, rich_help_panel=panel, epilog=examples, context_settings=settings)(function)
    return app


def main(args: list[str] | None = None) -> None:
    """Entry point of ``harness``.

    Exit status: 0 fine, 1 some cells failed, 2 a usage error, 70 what nobody foresaw, 130 interrupted.
    """
    with libraries_visible():
        status = _answer(sys.argv[1:] if args is None else args)
    sys.exit(status)


def _answer(args: list[str]) -> int:
    """The exit status; what went wrong is said in one line."""
    try:
        return _run(args)
    except TyperException as error:  # what typer refuses: an unknown option, a missing argument
        complain(_with_help(error))
        return error.exit_code
    except UsageError as error:
        complain(str(error))
        return USAGE
    except BrokenPipeError:  # who read what is printed, as head, has enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except (HarnessError, OSError) as error:
        return _say_failure(error)
    except Exception as error:  # nobody's traceback on the screen
        from harness.cli.unexpected import describe_unexpected

        complain(NO_TEXT if _is_no_text(error) else describe_unexpected(error))
        return USAGE if _is_no_text(error) else UNFORESEEN


def _take_allowed(args: list[str]) -> list[str]:
    """The arguments without what is allowed, which every command takes; what is typed is allowed besides."""
    rest, words = list[str](), iter(args)
    named: dict[str, list[str]] = {ALLOW: [], ALLOW_PROGRAM: []}
    for word in words:
        flag, equals, value = word.partition("=")
        if flag in named:
            named[flag].append(value if equals else next(words, ""))
        else:
            rest.append(word)
    allow_imports(named[ALLOW])
    allow_programs(named[ALLOW_PROGRAM])
    allow_typed(rest)
    return rest


def _say_failure(error: Exception) -> int:
    """Say what failed; the exit status."""
    if _has_long_name(error):
        complain(LONG_NAME)
        return USAGE
    is_ours = isinstance(error, HarnessError)
    complain(str(error) if is_ours else f"the system reports: {error}. Solve that, then run the same command again")
    return FAILED


def _has_long_name(error: Exception) -> bool:
    """Whether the system refused a path for its length: it stands in what was typed, for ours are short."""
    cause = error if isinstance(error, OSError) else error.__cause__
    return isinstance(cause, OSError) and cause.errno == errno.ENAMETOOLONG


def _is_no_text(error: Exception) -> bool:
    """Whether a library refused bytes of a name that stand for no text."""
    return isinstance(error, UnicodeEncodeError) and any("\udc80" <= char <= "\udcff" for char in error.object)


def _with_help(error: TyperException) -> str:
    """What typer says, with the flag that may be meant, and which help has examples of what it would take."""
    message, context = error.format_message(), getattr(error, "ctx", None)
    if context is None or not context.help_option_names:
        return message
    if (given := getattr(error, "option_name", None)) and hasattr(error, "possibilities"):
        message = f"No such option: {given}.{meant_flag(given, context.command)}"
    end = "" if message.endswith((".", "?")) else "."
    return f"{message}{end} Examples: {context.command_path} {context.help_option_names[0]}"


def _run(args: list[str]) -> int:
    args = _take_allowed(args)
    own = [name for commands in PANELS.values() for name in commands]
    if args and args[0] in own:  # it waits for no plugin
        app = build_app(args[0])
    else:
        from harness.cli.commands import add_plugin_commands, plugins_for

        registry, only = plugins_for(args)
        app = build_app(only)
        add_plugin_commands(app, registry, own)
    command = typer.main.get_command(app)
    status = 0 if args else USAGE  # nothing was asked for: the help says what there is
    return command.main(args or ["--help"], prog_name="harness", standalone_mode=False, obj=own) or status
