"""The flags of ``harness eta`` that no other command has."""

from pathlib import Path
from typing import Annotated

import typer

from harness.cli.flags.shared import REWARDS

TrainingsFolder = Annotated[
    Path | None,
    typer.Argument(
        help="A folder of trainings that harness.RecordRewards recorded, of an experiment, or of other logs.",
        metavar="FOLDER",
        show_default=False,
    ),
]
BaselineRuns = Annotated[
    list[str] | None,
    typer.Option(help="Runs of the baseline, such as 'base/*.csv'.", metavar="GLOB", show_default=False),
]
ProposedRuns = Annotated[
    list[str] | None,
    typer.Option(help="Runs of the proposed reward. ** stands for any folders.", metavar="GLOB", show_default=False),
]
WithEvents = Annotated[bool, typer.Option("--with-events", help="Add what the task pays for events to the reward.")]
BaselineReward = Annotated[
    str | None,
    typer.Option(
        help="The reward that the baseline's runs were trained with.",
        show_default="found out",
        metavar="NAME",
        autocompletion=REWARDS,
    ),
]
ProposedReward = Annotated[
    str | None,
    typer.Option(
        help="The reward that the proposed runs were trained with.",
        show_default="found out",
        metavar="NAME",
        autocompletion=REWARDS,
    ),
]
PlotFile = Annotated[Path | None, typer.Option(help="Draw the curves into this .html file.", metavar="FILE")]
