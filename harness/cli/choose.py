"""``harness choose``: the best of several rewards, with few trainings."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

from harness.cli.flags.shared import REWARDS, Names, flag
from harness.cli.help import takes
from harness.cli.output import say
from harness.cli.run import RunFlags, foresee_run, given_plugins, read_flags, screen, show_run, train
from harness.errors import UsageError

if TYPE_CHECKING:
    from harness.registry.given import Given
    from harness.registry.registry import Registry
    from harness.results import Results

Candidates = Annotated[
    Names, flag("NAME,...", "The candidates, such as arp,dense,relative.", "the rewards of the files", offers=REWARDS)
]
Looks = Annotated[
    str | None, flag("N,...", "The seeds of each reward in each place at each look.", "4,6,8,12,16,24,32")
]
CHOSEN = frozenset(
    [
        "experiment",
        "sim",
        "algo",
        "baseline",
        "task",
        "robot",
        "steps",
        "evaluation_episodes",
        "evaluate_every",
        "out",
        "jobs",
        "executor",
        "budget",
        "changed",
        "measure",
        "plugin",
        "screen",
        "watch",
        "quiet",
        "as_json",
        "dry_run",
        "help_all",
    ]
)
"""The flags of ``harness run`` that mean the same here."""


@takes(RunFlags, CHOSEN, reward=Candidates, looks=Looks)
def choose(**given: Any) -> int:
    """Find the best of several rewards. It trains all of them, and drops those that are beaten.

    The candidates are the rewards of the files, or those that are named; the baseline takes part too.
    """
    from harness.experiment.experiment import check
    from harness.registry.given import PluginFile
    from harness.registry.registry import load_registry

    plugins = tuple(
        replace(plugin, optional=True) if isinstance(plugin, PluginFile) else plugin for plugin in given_plugins(given)
    )
    registry = load_registry(given=plugins)
    if given["reward"] is None and given["experiment"] is None and given["sim"]:
        given["reward"] = _candidates(registry, plugins)
    asked, options = read_flags({**given, "until": "best"})
    ready = check(asked, options, plugins)
    if given["screen"]:
        screen(ready)
    if given["dry_run"]:
        return foresee_run(ready, given["as_json"])
    results, status = train(ready, given["quiet"], given["watch"])
    show_run(results, given["as_json"])
    if not given["as_json"]:
        _add(results, registry.broken_files())
    return status


def _candidates(registry: "Registry", plugins: "Sequence[Given]") -> list[str]:
    """The rewards that the given files register.

    Raises:
        UsageError: There is none.
    """
    names = {it.name for it in plugins}
    found = [spec.name for spec in registry.all_specs() if spec.kind == "rewards" and spec.plugin in names]
    if not found:
        raise UsageError(
            "which rewards? Name them, --reward arp,dense,relative, or give files of rewards, --plugin 'rewards/*.py'"
        )
    return found


def _add(results: "Results", left_out: Sequence[str]) -> None:
    """Why candidates are missing, and whether there is a race to tell of yet."""
    from harness.results.standing import standing_of

    for line in left_out:
        say(line)
    standing = standing_of(results)
    if standing is None or standing.race is None or not standing.race.looks:
        say("No look is complete yet: the same command goes on.")
