"""The flags of ``harness score`` that no other command has."""

from pathlib import Path
from typing import Annotated

import typer

from harness.cli.flags.shared import REWARDS, TASKS

Targets = Annotated[
    list[str],
    typer.Argument(
        help="An experiment's folder, a folder of recorded trainings, a data set, or files.",
        metavar="DIR|DATASET|FILES",
    ),
]
RewardNames = Annotated[
    list[str] | None,
    typer.Option(
        help="The rewards that pay the runs again, such as arp:k2=2.",
        metavar="NAME,...",
        show_default="in environments: all functions of --plugin",
        autocompletion=REWARDS,
    ),
]
Every = Annotated[bool, typer.Option("--all", help="Also use every reward that the experiment trained with.")]
Environment = Annotated[
    str | None,
    typer.Option(
        help="The environment that recorded trainings were made in.",
        show_default="by the id in the recording",
        metavar="NAME",
        autocompletion=TASKS,
    ),
]
OutFolder = Annotated[
    Path | None,
    typer.Option(
        help="Folder for the scores of files or of a data set.", show_default="beside each file", metavar="DIR"
    ),
]
