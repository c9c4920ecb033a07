"""What is checked, and its checks one by one. All of this runs in the process that the plugin may end or crash.

The plugin is imported here for the first time. `harness_plugins.kit.inspection.inspection` looks on from the process
of the command.
"""

import tempfile
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any, TypeAlias

import typer

from harness import load_robot
from harness.errors import HarnessError, PluginError, UsageError, one_line
from harness.hookspecs import KINDS, NOUNS, WORDS
from harness.registry import (
    Registry,
    Spec,
    choose,
    load_registry,
    parse,
    read_given,
    unknown_name,
)
from harness.registry.given import Given, PluginFile
from harness.registry.targets import why_unfit
from harness.robot import Robot
from harness.robot.robot import is_path
from harness.task import choose_task

from ..contract import Check, violations
from ..kits import KITS, WITH_FOLDER, WITH_ROBOT, Kit
from .ending import is_plugins_own
from .finding import LOADS, TARGET, Asked, Finding, Outline, PlannedCheck

DEFAULT_ROBOT = "fd100"
NO_KIT = "there is no contract kit for this kind of plugin: test what it does in its own package"

Tell: TypeAlias = Callable[[str], None]
"""A function that is told what is done next."""


@dataclass(frozen=True)
class Subject:
    """A plugin that can be checked, or why it cannot be.

    Attributes:
        outline: What is told of it.
        checks: All checks of its kind, those that take minutes too, by name; none if it cannot be checked.
        arguments: What each of them takes.
    """

    outline: Outline
    checks: tuple[Check, ...] = ()
    arguments: tuple[Any, ...] = ()


@lru_cache(maxsize=1)
def open_subject(asked: Asked, notes: Path) -> Subject:
    """Import and build what was asked for; a process does it once.

    Args:
        asked: What the user named.
        notes: A file that says what is done at the moment, ``plugin file 'mine.py' was imported``: if that ends the
            process, or never returns, the file is there to tell.
    """
    kind = ""

    def tell(doing: str) -> None:
        notes.write_text(doing, encoding="utf-8")

    try:
        registry = _load(asked, tell)
        fault = fault_of_package(registry, asked.name)
        if fault:
            return Subject(Outline(kind, (Finding(TARGET, "error", fault),)))
        kind = kind_of(registry, asked.name, asked.kind)
        return _open(registry, kind, asked, tell)
    except _NotLoaded as error:
        return Subject(Outline(kind, (Finding(TARGET, "error", str(error)),)))
    except UsageError as error:
        return Subject(Outline(kind, mistake=str(error)))
    except PluginError as error:
        return Subject(Outline(kind, (Finding(TARGET, "error", str(error), story=traceback.format_exc()),)))
    except BaseException as error:  # a plugin may raise anything; Ctrl-C does not reach this process
        sentence = f"raised {one_line(error)} ({_place_of(error)})"
        return Subject(Outline(kind, (Finding(TARGET, "error", sentence, story=traceback.format_exc()),)))


def kind_of(registry: Registry, name: str, kind: str | None) -> str:
    """The one kind of which something has this name.

    Raises:
        UsageError: None has, or several have and `kind` does not say which is meant.
    """
    singular = {word: plural for plural, word in WORDS.items()}
    if kind is not None:
        if kind not in {*KINDS, *singular}:
            raise UsageError(unknown_name("kind", kind, singular))
        return singular.get(kind, kind)
    bare = name.partition(":")[0]
    kinds = registry.kinds_of(bare)
    if not kinds and is_path(name):
        return "robots"
    if not kinds:
        raise UsageError(unknown_name("name", parse(name)[0], registry.all_names()) + registry.not_loaded())
    if len(kinds) > 1:
        raise UsageError(f"'{bare}' is a {' and a '.join(NOUNS[each] for each in kinds)}: add --kind {WORDS[kinds[0]]}")
    return kinds[0]


def fault_of_package(registry: Registry, name: str) -> str:
    """Why the package that is called like an unknown name did not load; empty if there is none, or it did."""
    bare = name.partition(":")[0]
    if registry.kinds_of(bare):
        return ""
    named = [plugin for plugin in registry.plugins if bare in (plugin.name, plugin.distribution)]
    return "; ".join(plugin.complaint for plugin in named if plugin.is_at_fault)


def run_check(subject: Subject, name: str) -> Finding:
    """Run one check of a subject; its arguments are copied for each."""
    check = next((check for check in subject.checks if check.name == name), None)
    if check is None:  # the subject was opened once more, in another process
        told = [finding.sentence for finding in subject.outline.findings] or [subject.outline.mistake]
        return Finding(name, "error", f"the plugin could be built before, and now it cannot: {'; '.join(told)}")
    begun = time.perf_counter()
    try:
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
            place = (Path(folder),) if WORDS.get(subject.outline.kind) in WITH_FOLDER else ()
            failed = next(violations([check], *subject.arguments, *place), None)
        cause = failed and failed.__cause__
    except BaseException as error:  # as KeyboardInterrupt, which nobody but the plugin raises here
        failed, cause = None, error
    seconds = time.perf_counter() - begun
    if failed is None and cause is None:
        return Finding(name, "ok", seconds=seconds)
    if cause is None or isinstance(cause, AssertionError):  # a check's own sentence says it all
        return Finding(name, check.level, failed.sentence if failed else "", seconds)
    sentence = f"raised {one_line(cause)} ({_place_of(cause)}). What has to hold: {check.fact}"
    return Finding(name, check.level, sentence, seconds, "".join(traceback.format_exception(cause)))


class _NotLoaded(Exception):
    """What was given by hand cannot be loaded."""


def _load(asked: Asked, tell: Tell) -> Registry:
    try:
        for name in asked.classes:
            tell(f"plugin '{name}' was imported")
        given = (*asked.files, *read_given(asked.classes))
        return load_registry(given=given, on_load=lambda plugin: tell(_import_in_words(plugin)))
    except UsageError as error:
        raise _NotLoaded(str(error)) from error


def _import_in_words(plugin: EntryPoint | Given) -> str:
    if isinstance(plugin, EntryPoint):
        package = f" of package {plugin.dist.name} {plugin.dist.version}" if plugin.dist else ""
        return f"plugin '{plugin.name}'{package} was imported (HARNESS_PLUGINS=-{plugin.name} leaves it out)"
    return f"plugin {'file ' * isinstance(plugin, PluginFile)}'{plugin.name}' was imported"


def _open(registry: Registry, kind: str, asked: Asked, tell: Tell) -> Subject:
    if kind == "robots":
        return _open_robot(registry, asked.name)
    if asked.robot is not None and WORDS[kind] not in WITH_ROBOT:
        raise UsageError(f"{NOUNS[kind]} '{asked.name}' is checked without a robot: leave --robot out")
    spec = registry.get(kind, parse(asked.name)[0])
    tell(f"{NOUNS[kind]} '{spec.name}' was imported and built")
    unfit = f"{spec.name} needs {', '.join(spec.missing)}: {spec.remedy}" if spec.missing else why_unfit(spec)
    if unfit:
        return Subject(Outline(kind, (Finding(TARGET, "error", unfit),)))
    if kind == "commands":
        return Subject(Outline(kind, (Finding(TARGET, "ok"), _command_finding(spec))))
    if kind == "tasks":
        chosen, arm = choose_task(registry, asked.name, asked.robot, partial(_robot, registry=registry))
        return _subject(kind, Finding(TARGET, "ok"), (chosen.build(registry, kind), arm))
    built = choose(registry, kind, asked.name).build(registry, kind)
    beside = (_robot(asked.robot or DEFAULT_ROBOT, registry),) if kind == "simulators" else ()
    return _subject(kind, Finding(TARGET, "ok"), (built, *beside))


def _open_robot(registry: Registry, name_or_path: str) -> Subject:
    try:
        robot = _robot(name_or_path, registry)
    except HarnessError as error:
        return Subject(Outline("robots", (Finding(LOADS, "error", str(error)),)))
    return _subject("robots", Finding(LOADS, "ok"), (robot,))


def _subject(kind: str, first: Finding, arguments: tuple[Any, ...]) -> Subject:
    kit = KITS.get(kind, Kit(()))
    told = (first,) if kit.contract else (first, Finding("contract", "not run", NO_KIT))
    planned = (PlannedCheck(check.name, check.fact, kit.seconds_of(check), check in kit.long) for check in kit.checks)
    return Subject(Outline(kind, told, tuple(planned)), kit.checks, arguments)


def _robot(name_or_path: str, registry: Registry) -> Robot:
    """A registered robot; or that of a folder beside, whose name needs no slash here."""
    is_folder = not registry.kinds_of(name_or_path) and Path(name_or_path).is_dir()
    return load_robot(Path(name_or_path) if is_folder else name_or_path, registry)


def _place_of(error: BaseException) -> str:
    """File and line where the plugin raised it: of its last call."""
    frames = traceback.extract_tb(error.__traceback__)
    last = ([frame for frame in frames if is_plugins_own(frame.filename)] or frames)[-1]
    return f"{Path(last.filename).name}, line {last.lineno}"


def _command_finding(spec: Spec) -> Finding:
    """Whether typer makes options of a command's parameters."""
    app = typer.Typer(add_completion=False)
    try:
        app.command()(spec.load())
        typer.main.get_command(app)
    except Exception as error:
        sentence = f"its parameters cannot be options: {one_line(error)}"
        return Finding("command-options", "error", sentence, story=traceback.format_exc())
    return Finding("command-options", "ok")
