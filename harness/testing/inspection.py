"""What ``harness check`` does: a registered name or a robot's files, and one finding for each check."""

import contextlib
import sys
import tempfile
import time
import traceback
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias

import typer

from harness.errors import HarnessError, PluginError, UsageError, one_line
from harness.hookspecs import NOUNS
from harness.registry.choice import choose, parse
from harness.registry.registry import Registry
from harness.registry.targets import why_unfit
from harness.robot import Robot
from harness.robot.load import load_robot
from harness.testing.kits import KITS, Kit
from harness.testing.violations import Check, violations

Verdict: TypeAlias = Literal["ok", "warning", "error", "not run"]
TARGET = "target"
"""Name of the check that comes before those of the kit: what is registered can be imported, and is of its kind."""
LOADS = "robot-loads"
"""The same of a robot: its files can be read."""
DEFAULT_ROBOT = "fd100"
WITH_ROBOT = ("simulators", "tasks")
"""The kinds that are checked with a robot."""
WITH_FOLDER = ("executors", "trackers")
"""The kinds that are checked in a folder."""


@dataclass(frozen=True)
class Finding:
    """What a check found.

    Attributes:
        check: Its name.
        verdict: How it went.
        sentence: What is wrong, with its numbers; empty where nothing is.
        seconds: What it took.
        story: The traceback behind it; empty where there is none.
    """

    check: str
    verdict: Verdict
    sentence: str = ""
    seconds: float = 0.0
    story: str = ""


def inspect_plugin(
    registry: Registry, kind: str, given: str, robot: str | None = None, long: bool = False
) -> Iterator[Finding]:
    """Check a registered name of one kind; each finding comes as soon as it is there.

    Args:
        registry: The plugins.
        kind: ``simulators`` and so on.
        given: The name, with parameters or without: ``arp:k2=2``; of a robot also a path.
        robot: The arm that a simulator or a task is checked with; fd100, or the task's own, if None.
        long: Whether to run the checks that take minutes too.

    Raises:
        UsageError: The name is unknown, or its parameters cannot be.
    """
    if kind == "robots":
        yield from inspect_robot(registry, given)
        return
    if robot is not None and kind not in WITH_ROBOT:
        raise UsageError(f"{NOUNS[kind]} '{given}' is checked without a robot: leave --robot out")
    spec = registry.get(kind, parse(given)[0])
    unfit = f"{spec.name} needs {', '.join(spec.missing)}: {spec.remedy}" if spec.missing else why_unfit(spec)
    if unfit:
        yield Finding(TARGET, "error", unfit)
    elif kind == "commands":
        yield Finding(TARGET, "ok")
        yield _command_finding(spec.load())
    else:
        yield from _inspect_built(registry, kind, given, robot, long)


def _inspect_built(registry: Registry, kind: str, given: str, robot: str | None, long: bool) -> Iterator[Finding]:
    try:
        built = choose(registry, kind, given).build(registry, kind)
        subject = (built, *_beside(kind, built, robot, registry))
    except PluginError as error:
        yield Finding(TARGET, "error", str(error), story=traceback.format_exc())
        return
    yield Finding(TARGET, "ok")
    yield from _run(KITS[kind], kind, subject, long)


def inspect_robot(registry: Registry, name_or_path: str) -> Iterator[Finding]:
    """Check a registered robot, or the one that a path leads to; see `inspect_plugin`."""
    try:
        robot = _robot(name_or_path, registry)
    except HarnessError as error:
        yield Finding(LOADS, "error", str(error))
        return
    yield Finding(LOADS, "ok")
    yield from _run(KITS["robots"], "robots", (robot,), long=False)


def _beside(kind: str, built: Any, robot: str | None, registry: Registry) -> tuple[Robot, ...]:
    """What the checks of a kind take beside the plugin."""
    if kind == "simulators":
        return (_robot(robot or DEFAULT_ROBOT, registry),)
    return (_robot(robot or built.robot, registry),) if kind == "tasks" else ()


def _robot(name_or_path: str, registry: Registry) -> Robot:
    """A registered robot; or that of a folder beside, whose name needs no slash here."""
    is_folder = not registry.kinds_of(name_or_path) and Path(name_or_path).is_dir()
    return load_robot(Path(name_or_path) if is_folder else name_or_path, registry)


def _run(kit: Kit, kind: str, subject: tuple[Any, ...], long: bool) -> Iterator[Finding]:
    for check in (*kit.contract, *kit.advice, *(kit.long if long else ())):
        with _place(kind) as folder:
            yield _finding(check, (*subject, *folder))
    if not long:
        yield from (Finding(check.name, "not run", "takes minutes: add --long") for check in kit.long)


@contextlib.contextmanager
def _place(kind: str) -> Iterator[tuple[Path, ...]]:
    """An empty folder for each check of an executor or a tracker; nothing for the others."""
    if kind not in WITH_FOLDER:
        yield ()
        return
    with tempfile.TemporaryDirectory() as folder:
        yield (Path(folder),)


def _finding(check: Check, subject: tuple[Any, ...]) -> Finding:
    """Run one check; what the plugin prints goes to standard error."""
    begun = time.perf_counter()
    with contextlib.redirect_stdout(sys.stderr):
        failed = next(violations([check], *subject), None)
    seconds = time.perf_counter() - begun
    if failed is None:
        return Finding(check.name, "ok", seconds=seconds)
    cause = failed.__cause__
    if cause is None or isinstance(cause, AssertionError):  # a check's own sentence says it all
        return Finding(check.name, check.level, failed.sentence, seconds)
    sentence = f"{failed.sentence} ({_place_of(cause)}). What has to hold: {check.fact}"
    return Finding(check.name, check.level, sentence, seconds, "".join(traceback.format_exception(cause)))


def _place_of(error: BaseException) -> str:
    """File and line where the plugin raised it: of the last call that is none of the kit's."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if Path(__file__).parent not in Path(frame.filename).parents] or frames
    return f"{Path(own[-1].filename).name}, line {own[-1].lineno}"


def _command_finding(function: Any) -> Finding:
    """Whether typer makes options of a command's parameters."""
    app = typer.Typer(add_completion=False)
    try:
        app.command()(function)
        typer.main.get_command(app)
    except Exception as error:
        sentence = f"its parameters cannot be options: {one_line(error)}"
        return Finding("command-options", "error", sentence, story=traceback.format_exc())
    return Finding("command-options", "ok")


def count(findings: Iterable[Finding], verdict: Verdict) -> int:
    """How many findings there are of one verdict."""
    return sum(finding.verdict == verdict for finding in findings)
