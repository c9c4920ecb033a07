"""``harness check``: does a plugin, or a robot, do what the harness relies on?"""

import signal
import sys
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Any

import typer

from harness.cli.flags.shared import ROBOT, AsJson, PluginFiles
from harness.cli.output import say, say_json
from harness.errors import UsageError

if TYPE_CHECKING:
    from .finding import Finding


PluginName = Annotated[
    str | None,
    typer.Argument(help="A plugin's name, such as arp or sac:gamma=0.9, or the path of a URDF.", show_default=False),
]
Kind = Annotated[
    str | None,
    typer.Option(
        help="The kind, such as reward, if several kinds have a plugin of this name.",
        metavar="KIND",
        show_default=False,
    ),
]
RobotName = Annotated[
    str | None,
    typer.Option(help=f"{ROBOT} Without NAME the robot itself is checked.", metavar="NAME", show_default=False),
]
Long = Annotated[bool, typer.Option("--long", help="Also run the checks that take minutes.")]
CheckTime = Annotated[
    float | None,
    typer.Option(
        help="Seconds that each check may take. After that its process is ended, and the check has failed.",
        show_default="15 for a reward or metric, 300 for an algorithm, 120 for a robot, else 60",
        metavar="SECONDS",
        min=1.0,
    ),
]
Verbose = Annotated[bool, typer.Option("--verbose", help="Show the traceback of a plugin's error, on standard error.")]


DOCS = "docs/contracts.md"
NAME_WIDTH, VERDICT_WIDTH = 28, 9
ENDING = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Signals that ask a process to end, beside that of Ctrl-C."""


def check(
    name: PluginName = None,
    kind: Kind = None,
    robot: RobotName = None,
    plugin: PluginFiles = None,
    long: Long = False,
    check_time: CheckTime = None,
    verbose: Verbose = False,
    as_json: AsJson = False,
) -> int:
    """Check whether a plugin or robot keeps the rules of its kind. Each result is a sentence with numbers.

    Ends with status 1 if a rule is broken.
    """
    from .finding import Asked, read_plugins
    from .inspection import Inspection

    if name is None and robot is None:
        raise UsageError("nothing to check: type harness check NAME, or harness check --robot FOLDER")
    plugins = read_plugins(plugin or [])
    asked = Asked(robot or "", "robots", None, *plugins) if name is None else Asked(name, kind, robot, *plugins)
    inspection, found = Inspection(asked, long, check_time), list["Finding"]()
    with _ended_by_signals():
        for finding in inspection.findings():
            found.append(finding)
            if finding.printed:
                say(finding.printed.removesuffix("\n"), err=True)
            if not as_json:
                _show(finding)
            if verbose and finding.story:
                say(finding.story, err=True)
    _conclude(inspection.kind, asked.name, found, as_json)
    return 1 if any(finding.verdict == "error" for finding in found) else 0


@contextmanager
def _ended_by_signals() -> Iterator[None]:
    """Within this block a signal that ends this process is an exception first, so that other processes end with it."""

    def leave(number: int, _: Any) -> None:
        sys.exit(128 + number)  # as a shell says it

    before = {number: signal.signal(number, leave) for number in ENDING}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _show(finding: "Finding") -> None:
    """A row; a long sentence goes on below itself."""
    from shutil import get_terminal_size

    head = f"{finding.check:<{NAME_WIDTH}}{finding.verdict:<{VERDICT_WIDTH}}"
    width = max(get_terminal_size().columns, len(head) + 40)
    lines = textwrap.wrap(finding.sentence, width - len(head), break_on_hyphens=False) or [""]
    say("\n".join([f"{head}{lines[0]}".rstrip(), *(" " * len(head) + line for line in lines[1:])]))


def _conclude(kind: str, given: str, found: list["Finding"], as_json: bool) -> None:
    from harness.hookspecs import NOUNS

    from .finding import count

    noun = NOUNS.get(kind)
    numbers = {"ok": count(found, "ok"), "warnings": count(found, "warning"), "errors": count(found, "error")}
    if as_json:
        shown = ("check", "verdict", "sentence", "seconds")
        checks = [{key: value for key, value in asdict(finding).items() if key in shown} for finding in found]
        say_json({"kind": noun, "name": given, **numbers, "checks": checks})
        return
    told = ", ".join(f"{number} {noun.removesuffix('s') if number == 1 else noun}" for noun, number in numbers.items())
    say(f"{noun or 'plugin'} {given}: {told}. {DOCS} explains every check.")


check.examples = (  # type: ignore[attr-defined] # harness shows them
    "harness check arp",
    "harness check sac:gamma=0.9 --kind algorithm",
    "harness check mujoco --robot robots/mine --json",
    "harness check --robot robots/mine",
    "harness check my-reward --plugin my_reward.py",
)
