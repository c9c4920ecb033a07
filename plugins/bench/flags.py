"""The flags of ``harness bench`` that no other command has."""

from pathlib import Path
from typing import Annotated

import typer

from harness.authoring.commands import ALGORITHMS, REWARDS

Names = list[str] | None

CELL_ROUNDS, SPEED_ROUNDS = 3, 9
"""How many processes time everything where nobody says: the cells, and all else."""

Tables = Annotated[
    list[str] | None,
    typer.Argument(
        help="cells: where the time of a training goes. simulators: speed compared with the bare engine. "
        "algorithms: speed compared with the bare library. peers: speed compared with other projects.",
        show_default="cells",
        metavar="WHAT",
    ),
]
AlgorithmNames = Annotated[
    Names,
    typer.Option(
        help="Algorithms to time, such as sac:net_arch=256x256.", metavar="NAME,...", autocompletion=ALGORITHMS
    ),
]
RewardNames = Annotated[
    Names,
    typer.Option(help="Rewards to time.", show_default="baseline", metavar="NAME,...", autocompletion=REWARDS),
]
Steps = Annotated[
    int | None,
    typer.Option(
        help="Environment steps of each training.", show_default="2000; for algorithms and peers 256", metavar="N"
    ),
]
NumEnvs = Annotated[
    str | None,
    typer.Option(help="For simulators: how many arms they move at once.", show_default="1,64,1024", metavar="N,..."),
]
Rounds = Annotated[
    int | None,
    typer.Option(
        help="How many processes, one after the other, time everything.",
        show_default=f"{CELL_ROUNDS}; for simulators, algorithms and peers {SPEED_ROUNDS}",
        metavar="N",
    ),
]
OldFile = Annotated[
    Path | None,
    typer.Option(
        help="Measure again what this file holds. Ends with status 1 if something became slower.",
        metavar="OLD.json",
    ),
]
HtmlFile = Annotated[Path | None, typer.Option(help="Write a page with a figure to this file.", metavar="FILE")]
