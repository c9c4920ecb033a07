"""Flags of commands that read data sets."""

from typing import Annotated

import typer

Places = Annotated[
    str | None,
    typer.Option(
        help="Of a data set: where an arm's end effector and target stand in the observation, [m], such as "
        "end_effector=0:3,target=3:6; or joints=0:6 with --robot.",
        metavar="MAP",
        show_default=False,
    ),
]
Partial = Annotated[
    bool, typer.Option("--partial", help="Of a data set: take what is there, if it is less than the metadata declares.")
]
