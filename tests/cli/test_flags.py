"""The flags of all commands."""

import inspect
from collections import defaultdict
from collections.abc import Callable, Iterable
from typing import Annotated, get_args

import typer

from harness.cli.app import build_app

Quiet = Annotated[bool, typer.Option("--quiet", help="Say nothing.")]


def written_twice(commands: Iterable[Callable[..., object]]) -> set[str]:
    """Help of the flags that are written down more than once, so that one could be changed without the other."""
    places = defaultdict(set)
    for command in commands:
        for parameter in inspect.signature(command).parameters.values():
            for info in get_args(parameter.annotation)[1:]:
                places[type(info), info.help, info.metavar, info.show_default].add(id(info))
    return {help_text for (_, help_text, *_), found in places.items() if len(found) > 1}


def test_flags_that_are_the_same_are_shared():
    """They stand in `harness.cli.flags.shared`."""
    assert written_twice(it.callback for it in build_app().registered_commands) == set()


def test_flag_that_is_written_twice_is_found():
    """The mutant: one command has a flag of another, in words of its own."""

    def one(quiet: Quiet = False) -> None: ...

    def two(quiet: Quiet = False) -> None: ...

    def other(quiet: Annotated[bool, typer.Option("--quiet", help="Say nothing.")] = False) -> None: ...

    assert written_twice([one, two]) == set()
    assert written_twice([one, two, other]) == {"Say nothing."}
