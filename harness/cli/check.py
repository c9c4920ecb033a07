"""``harness check``: does a plugin, or a robot, do what the harness relies on?"""

import textwrap
from dataclasses import asdict
from typing import TYPE_CHECKING

from harness.cli.flags import check as flags
from harness.cli.flags.shared import AsJson, PluginFiles
from harness.cli.lines import say, say_json
from harness.errors import UsageError

if TYPE_CHECKING:
    from harness.registry.registry import Registry
    from harness.testing.inspection import Finding

DOCS = "docs/contracts.md"
NAME_WIDTH, VERDICT_WIDTH = 28, 9


def check(
    name: flags.PluginName = None,
    kind: flags.Kind = None,
    robot: flags.RobotName = None,
    plugin: PluginFiles = None,
    long: flags.Long = False,
    verbose: flags.Verbose = False,
    as_json: AsJson = False,
) -> int:
    """Check whether a plugin or robot keeps the rules of its kind. Each result is a sentence with numbers.

    Ends with status 1 if a rule is broken.
    """
    from harness.registry.given import read_given
    from harness.registry.registry import load_registry
    from harness.testing.inspection import inspect_plugin

    registry = load_registry(given=read_given(plugin))
    if name is None and robot is None:
        raise UsageError("nothing to check: type harness check NAME, or harness check --robot FOLDER")
    given, other = (robot or "", None) if name is None else (name, robot)
    chosen = "robots" if name is None else _kind_of(registry, name, kind)
    found: list[Finding] = []
    for finding in inspect_plugin(registry, chosen, given, other, long):
        found.append(finding)
        if not as_json:
            _show(finding)
        if verbose and finding.story:
            say(finding.story, err=True)
    _conclude(chosen, given, found, as_json)
    return 1 if any(finding.verdict == "error" for finding in found) else 0


def _kind_of(registry: "Registry", name: str, kind: str | None) -> str:
    """The one kind of which something has this name.

    Raises:
        UsageError: None has, or several have and `kind` does not say which is meant.
    """
    from harness.hookspecs import KINDS, NOUNS
    from harness.registry.choice import parse
    from harness.registry.names import unknown_name
    from harness.robot.load import is_path

    singular = {noun: plural for plural, noun in NOUNS.items()}
    if kind is not None:
        if kind not in {*KINDS, *singular}:
            raise UsageError(unknown_name("kind", kind, singular))
        return singular.get(kind, kind)
    bare = parse(name)[0] if not is_path(name) or registry.kinds_of(name) else name
    kinds = registry.kinds_of(bare)
    if not kinds and is_path(name):
        return "robots"
    if not kinds:
        raise UsageError(unknown_name("name", bare, registry.all_names()))
    if len(kinds) > 1:
        raise UsageError(f"'{bare}' is a {' and a '.join(NOUNS[each] for each in kinds)}: add --kind {NOUNS[kinds[0]]}")
    return kinds[0]


def _show(finding: "Finding") -> None:
    """A row; a long sentence goes on below itself."""
    from shutil import get_terminal_size

    head = f"{finding.check:<{NAME_WIDTH}}{finding.verdict:<{VERDICT_WIDTH}}"
    width = max(get_terminal_size().columns, len(head) + 40)
    lines = textwrap.wrap(finding.sentence, width - len(head), break_on_hyphens=False) or [""]
    say("\n".join([f"{head}{lines[0]}".rstrip(), *(" " * len(head) + line for line in lines[1:])]))


def _conclude(kind: str, given: str, found: list["Finding"], as_json: bool) -> None:
    from harness.hookspecs import NOUNS
    from harness.testing.inspection import count

    numbers = {"ok": count(found, "ok"), "warnings": count(found, "warning"), "errors": count(found, "error")}
    if as_json:
        checks = [{key: value for key, value in asdict(finding).items() if key != "story"} for finding in found]
        say_json({"kind": NOUNS[kind], "name": given, **numbers, "checks": checks})
        return
    told = ", ".join(f"{number} {noun.removesuffix('s') if number == 1 else noun}" for noun, number in numbers.items())
    say(f"{NOUNS[kind]} {given}: {told}. {DOCS} explains every check.")
