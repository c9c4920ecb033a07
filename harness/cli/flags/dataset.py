"""Flags of commands that read data sets."""

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
        help="Of a data set: the key, column or attribute that says whether a step, or an episode, was a success; with "
        "a threshold where it is a number, 'KEY>0.5'.",
        metavar="KEY[>NUMBER]",
        show_default="success, is_success or next.success",
    ),
]
LabelsFile = Annotated[
    Path | None,
    typer.Option(
        help="Of a data set: a CSV file with the columns episode and success, a line for each episode.",
        metavar="FILE",
        show_default=False,
    ),
]
SuccessAbove = Annotated[
    float | None,
    typer.Option(
        help="Of a data set: the recorded return above which an episode is a success.",
        metavar="RETURN",
        show_default=False,
    ),
]
Partial = Annotated[
    bool, typer.Option("--partial", help="Of a data set: take what is there, if it is less than the metadata declares.")
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
