"""Flags that mean the same in several commands."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias

import typer

from harness.text import visible

Complete: TypeAlias = Callable[[str], list[tuple[str, str]]]


def flag(
    metavar: str, text: str, shown: str | bool = True, *, name: str | None = None, offers: Complete | None = None
) -> Any:
    """A flag that takes a value.

    Args:
        metavar: What stands for the value in the help.
        text: The help.
        shown: The default in words, where its value does not say it; False for none.
        name: The flag, where it is not called like the parameter.
        offers: What a shell offers behind it.
    """
    names = () if name is None else (name,)
    return typer.Option(*names, help=text, show_default=shown, metavar=metavar, autocompletion=offers)


def names_of(*kinds: str) -> Complete:
    """Offers the names of some kinds of plugins, after a comma too, each with its summary."""

    def complete(incomplete: str) -> list[tuple[str, str]]:
        return [offer for kind in kinds for offer in _offers(kind, incomplete)]

    return complete


def _offers(kind: str, incomplete: str) -> Iterator[tuple[str, str]]:
    from harness.registry.registry import load_registry

    before, comma, begun = incomplete.rpartition(",")
    registry = load_registry()
    for name in registry.typed_names(kind):
        if name.startswith(begun):
            yield f"{before}{comma}{name}", visible(registry.get(kind, name).summary)


ROBOT = "The robot: a name, the path of a URDF, or a folder with a robot.toml."

Names = list[str] | None
SIMULATORS, ALGORITHMS, REWARDS = names_of("simulators"), names_of("algorithms"), names_of("rewards")
TASKS, ROBOTS, TRACKERS = names_of("tasks", "environments"), names_of("robots"), names_of("trackers")
"""What a shell offers behind these flags."""

ExperimentFolder = Annotated[Path, typer.Argument(help="The experiment's folder.", metavar="DIR")]
SimulatorNames = Annotated[Names, flag("NAME,...", "Simulators, such as mujoco.", offers=SIMULATORS)]
RewardNames = Annotated[Names, flag("NAME,...", "Proposed rewards, such as arp:k2=2.", "arp,dense", offers=REWARDS)]
TaskName = Annotated[
    str | None,
    flag(
        "NAME",
        "The task, such as fd100-reach:epsilon=0.02, or an environment, such as fetch-reach.",
        "fd100-reach",
        offers=TASKS,
    ),
]
ExecutorName = Annotated[
    str, flag("NAME", "Where the cells run: processes, ray or slurm.", offers=names_of("executors"))
]
RobotName = Annotated[str | None, flag("NAME", ROBOT, "the task's", offers=ROBOTS)]
PluginFiles = Annotated[
    list[str] | None,
    flag(
        "FILE",
        "A Python file of reward functions or plugins, or a pattern: 'rewards/*.py'. Can be repeated.",
        False,
        name="--plugin",
    ),
]
MetricNames = Annotated[
    Names,
    flag(
        "NAME,...",
        "Metrics to show, or measures of an environment. What decides the verdict is always shown.",
        "all",
        name="--metric",
        offers=names_of("metrics"),
    ),
]
CurveKind = Annotated[
    Literal["accumulated", "per-step"],
    typer.Option(
        help="Compute I_N and I_P from the running sum of the rewards, as published, or from the reward of each step "
        "(NOTE eq. 39-42 read literally)."
    ),
]
EvaluationEpisodes = Annotated[int | None, flag("N", "Episodes of each evaluation.", "100")]
Jobs = Annotated[int | None, flag("N", "How many trainings run at once.", "one per core")]
FailOn = Annotated[
    Names,
    flag(
        "ANSWER,...",
        "End with status 1 if one of these answers is given, with 3 if that cannot be told. A wrong name lists them.",
        "no answer changes the status",
        name="--fail-on",
    ),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON on standard output.")]
Measures = Annotated[
    Names,
    flag(
        "FILE|NAME,...",
        "What decides: a Python file of functions that measure behaviour, or the name of a measure.",
        "success, else the first measure; of an arm success_rate",
        name="--measure",
    ),
]
