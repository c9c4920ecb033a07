"""The flags of commands that open logs of trainings which anybody left."""

from pathlib import Path
from typing import Annotated

import typer

from harness.cli.completion import names_of

AsFormat = Annotated[
    str | None,
    typer.Option(
        "--as",
        help="The format of logs, with its settings: monitor:success=is_success.",
        metavar="FORMAT",
        show_default="found out",
        autocompletion=names_of("logs"),
    ),
]
SortBy = Annotated[
    str | None,
    typer.Option(
        "--sort",
        help="How names of logs are made, such as '{reward}/{seed}' or '*_{reward}_s{seed}'. What it fits is one "
        "training: '{reward}' says that all files of a folder are one.",
        metavar="TEMPLATE",
        show_default="what differs: a number is the seed",
    ),
]
LabelsFile = Annotated[
    Path | None,
    typer.Option(
        "--labels",
        help="Of logs: a CSV file with the columns run and success, or run, episode and success. A run is REWARD/SEED.",
        metavar="FILE",
        show_default=False,
    ),
]
DecidedBy = Annotated[
    str | None,
    typer.Option(
        "--measure",
        help="Of logs: what decides, such as success or length:better=lower. return decides where one and the same "
        "reward paid all of them.",
        metavar="NAME",
        show_default="success",
    ),
]
BaselineName = Annotated[
    str | None,
    typer.Option(
        "--baseline",
        help="Of logs and recorded trainings: the reward that the others are compared with.",
        metavar="NAME",
        show_default="one called base",
    ),
]
