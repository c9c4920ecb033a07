"""Flags of commands that read data sets of Minari and LeRobot."""

from pathlib import Path
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
Success = Annotated[
    str | None,
    typer.Option(
        help="Of a data set: the key of infos, or the column, that says whether a step was a success.",
        metavar="KEY",
        show_default="success, is_success or next.success",
    ),
]
Cluster = Annotated[
    str | None,
    typer.Option(
        help="Of a data set: what says who made an episode, an attribute or a column; or file.",
        metavar="KEY",
        show_default="operator, else each episode by itself",
    ),
]
Beginner = Annotated[
    str | None,
    typer.Option(
        help="Another data set, of which episodes should be paid less.", metavar="DATASET", show_default=False
    ),
]
HtmlFile = Annotated[
    Path | None, typer.Option(help="Of a data set: write the page with the curves to this file.", metavar="FILE")
]
