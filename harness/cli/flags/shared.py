"""Flags that mean the same in several commands."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from harness.cli.completion import names_of

ROBOT = "The robot: a name, the path of a URDF, or a folder with a robot.toml."

Names = list[str] | None
SIMULATORS, ALGORITHMS, REWARDS = names_of("simulators"), names_of("algorithms"), names_of("rewards")
TASKS, ROBOTS, TRACKERS = names_of("tasks", "environments"), names_of("robots"), names_of("trackers")
"""What a shell offers behind these flags."""

ExperimentFolder = Annotated[Path, typer.Argument(help="The experiment's folder.", metavar="DIR")]
SimulatorNames = Annotated[
    Names, typer.Option(help="Simulators, such as mujoco.", metavar="NAME,...", autocompletion=SIMULATORS)
]
RewardNames = Annotated[
    Names,
    typer.Option(
        help="Proposed rewards, such as arp:k2=2.", show_default="arp", metavar="NAME,...", autocompletion=REWARDS
    ),
]
TaskName = Annotated[
    str | None,
    typer.Option(
        help="The task, such as fd100-reach:epsilon=0.02, or an environment, such as fetch-reach.",
        show_default="fd100-reach",
        metavar="NAME",
        autocompletion=TASKS,
    ),
]
ExecutorName = Annotated[
    str,
    typer.Option(
        help="Where the cells run: processes, ray or slurm.", metavar="NAME", autocompletion=names_of("executors")
    ),
]
RobotName = Annotated[
    str | None,
    typer.Option(help=ROBOT, show_default="the task's", metavar="NAME", autocompletion=ROBOTS),
]
PluginFiles = Annotated[
    list[str] | None,
    typer.Option(
        "--plugin",
        help="A Python file of reward functions or plugins, or a pattern: 'rewards/*.py'. Can be repeated.",
        metavar="FILE",
        show_default=False,
    ),
]
MetricNames = Annotated[
    Names,
    typer.Option(
        "--metric",
        help="Metrics to show, or measures of an environment. What decides the verdict is always shown.",
        show_default="all",
        metavar="NAME,...",
        autocompletion=names_of("metrics"),
    ),
]
CurveKind = Annotated[
    Literal["accumulated", "per-step"],
    typer.Option(
        help="Compute I_N and I_P from the running sum of the rewards, as published, or from the reward of each step "
        "(NOTE eq. 39-42 read literally)."
    ),
]
EvaluationEpisodes = Annotated[
    int | None, typer.Option(help="Episodes of each evaluation.", show_default="100", metavar="N")
]
Jobs = Annotated[
    int | None, typer.Option(help="How many trainings run at once.", show_default="one per core", metavar="N")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON on standard output.")]
Measures = Annotated[
    Names,
    typer.Option(
        "--measure",
        help="What decides: a Python file of functions that measure behaviour, or the name of a measure.",
        show_default="success, else the first measure; of an arm success_rate",
        metavar="FILE|NAME,...",
    ),
]
