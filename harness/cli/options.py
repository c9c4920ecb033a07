"""Flags that mean the same in several commands."""

from typing import Annotated, Literal

import typer

ROBOT = "Robot: a name, a URDF, or a folder with robot.toml."

Names = list[str] | None
RewardNames = Annotated[
    Names, typer.Option(help="Proposed rewards, as arp:k1=1,k2=2.", show_default="arp", metavar="NAME,...")
]
TaskName = Annotated[
    str | None, typer.Option(help="As fd100-reach:epsilon=0.02.", show_default="fd100-reach", metavar="NAME")
]
ExecutorName = Annotated[str, typer.Option(help="What runs the cells, as processes.", metavar="NAME")]
RobotName = Annotated[str | None, typer.Option(help=ROBOT, show_default="the task's", metavar="NAME")]
CurveKind = Annotated[
    Literal["accumulated", "per-step"],
    typer.Option(help="Curves of the indices: as published, or NOTE eq. 39-42 read literally."),
]
