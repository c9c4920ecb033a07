"""The flags of ``harness audit`` that no other command has."""

from pathlib import Path
from typing import Annotated

import typer

from harness.cli.flags.shared import REWARDS, SIMULATORS

RewardName = Annotated[
    str | None,
    typer.Option(
        help="The reward, such as arp:k2=2, or several.", metavar="NAME,...", autocompletion=REWARDS, show_default=False
    ),
]
SimulatorName = Annotated[
    str | None,
    typer.Option(
        help="The simulator. Without one the joints move exactly as commanded.",
        metavar="NAME",
        autocompletion=SIMULATORS,
    ),
]
Against = Annotated[
    str | None,
    typer.Option(
        help="The reward to compare with: how far apart the two are.",
        show_default="baseline",
        metavar="NAME",
        autocompletion=REWARDS,
    ),
]
Episodes = Annotated[
    int | None, typer.Option(help="Episodes of each scripted policy.", show_default="100", metavar="N")
]
Gamma = Annotated[
    float | None,
    typer.Option(help="The discount factor of the learner, per step.", show_default="0.95", metavar="G"),
]
RandomFolder = Annotated[
    Path | None,
    typer.Option(
        help="A folder of recordings with random actions, to compare FOLDER with.",
        metavar="FOLDER",
        show_default=False,
    ),
]
