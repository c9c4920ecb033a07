"""The flags of ``harness parity`` that no other command has."""

from pathlib import Path
from typing import Annotated

import typer

from harness.cli.flags.shared import ROBOT, ROBOTS, SIMULATORS, Names

SimulatorNames = Annotated[
    Names,
    typer.Option(
        help="Simulators, such as mujoco:substeps=40.",
        show_default="all",
        metavar="NAME,...",
        autocompletion=SIMULATORS,
    ),
]
Reference = Annotated[
    str | None,
    typer.Option(
        help="The simulator that the others are compared with.",
        show_default="mujoco",
        metavar="NAME",
        autocompletion=SIMULATORS,
    ),
]
RobotName = Annotated[str, typer.Option(help=ROBOT, metavar="NAME", autocompletion=ROBOTS)]
Steps = Annotated[int, typer.Option(help="Control periods of each motion.", metavar="N")]
Episodes = Annotated[int, typer.Option(help="How many motions, and how many dives to the ground.", metavar="N")]
Seed = Annotated[int, typer.Option(help="The seed of the random motions.", metavar="S")]
Period = Annotated[float, typer.Option(help="Control period in seconds.", metavar="T")]
HtmlFile = Annotated[Path | None, typer.Option(help="Write a page with figures to this file.", metavar="FILE")]
