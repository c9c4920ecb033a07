"""The flags of ``harness check`` that no other command has."""

from typing import Annotated

import typer

from harness.cli.flags.shared import ROBOT

PluginName = Annotated[
    str | None,
    typer.Argument(help="A plugin's name, such as arp or sac:gamma=0.9, or the path of a URDF.", show_default=False),
]
Kind = Annotated[
    str | None,
    typer.Option(
        help="The kind, such as reward, if several kinds have a plugin of this name.",
        metavar="KIND",
        show_default=False,
    ),
]
RobotName = Annotated[
    str | None,
    typer.Option(help=f"{ROBOT} Without NAME the robot itself is checked.", metavar="NAME", show_default=False),
]
Long = Annotated[bool, typer.Option("--long", help="Also run the checks that take minutes.")]
CheckTime = Annotated[
    float | None,
    typer.Option(
        help="Seconds that each check may take. After that its process is ended, and the check has failed.",
        show_default="15 for a reward or metric, 300 for an algorithm, 120 for an executor, else 60",
        metavar="SECONDS",
        min=1.0,
    ),
]
Verbose = Annotated[bool, typer.Option("--verbose", help="Show the traceback of a plugin's error, on standard error.")]
