"""``harness choose``: which of several rewards goes furthest within a budget, and whether it helps."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

from harness.cli.flags.shared import REWARDS, Names, flag
from harness.cli.help import takes
from harness.cli.output import say
from harness.cli.run import RunFlags, foresee_run, given_plugins, parse_time, read_flags, screen, show_run, train
from harness.errors import UsageError

if TYPE_CHECKING:
    from harness.registry.choice import Registry
    from harness.registry.given import Given

Candidates = Annotated[
    Names, flag("NAME,...", "The candidates, such as arp,dense,relative.", "the rewards of the files", offers=REWARDS)
]
Budget = Annotated[
    str | None,
    flag(
        "N|TIME",
        "How many trainings it may take, such as 60, or how long, such as 10min or 2h.",
        "20, and 4 for each candidate, in each place",
        name="--budget",
    ),
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


@takes(RunFlags, CHOSEN, reward=Candidates, budget=Budget)
def choose(**given: Any) -> int:
    """See which of several rewards goes furthest, and whether it helps.

    With half of a budget it trains all candidates, and the worse half of them leaves again and again. With the rest
    it trains the one that is left and the baseline anew, and compares these new trainings alone. The candidates are the
    rewards of the files, or those that are named.
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
    asked, options = read_flags({**given, **_spend(given["budget"]), "until": "best", "looks": None})
    ready = check(asked, options, plugins)
    if given["screen"]:
        screen(ready)
    if given["dry_run"]:
        return foresee_run(ready, given["as_json"])
    results, status = train(ready, given["quiet"], given["watch"])
    show_run(results, given["as_json"])
    if not given["as_json"]:
        for line in registry.broken_files():
            say(line)
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


def _spend(budget: str | None) -> dict[str, Any]:
    """The keys of an experiment for ``--budget``.

    Raises:
        UsageError: It is neither a number of trainings nor a time.
    """
    if budget is None or budget.strip().isdigit():
        return {"trainings": None if budget is None else int(budget), "budget": None}
    try:
        return {"minutes": parse_time(budget) / 60.0, "budget": None}
    except UsageError:
        raise UsageError(
            f"--budget {budget}: give a number of trainings, such as 60, or a time, such as 10min"
        ) from None
