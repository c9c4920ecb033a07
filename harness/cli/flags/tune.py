"""The flags of ``harness tune`` that no other command has."""

from pathlib import Path
from typing import Annotated

import typer

from harness.cli.flags.shared import ALGORITHMS, REWARDS, SIMULATORS, Names

TuningFile = Annotated[
    Path | None,
    typer.Argument(help="Tuning file (TOML). Its keys are named like the flags; a flag overrides its key."),
]
SimulatorName = Annotated[Names, typer.Option(help="The simulator.", metavar="NAME", autocompletion=SIMULATORS)]
AlgorithmName = Annotated[
    Names,
    typer.Option(
        help="The algorithm, with parameters that stay fixed, such as sac:tau=0.01.",
        metavar="NAME",
        autocompletion=ALGORITHMS,
    ),
]
Baseline = Annotated[
    str | None,
    typer.Option(
        help="The reward that the others are compared with. It is tuned too.",
        show_default="baseline",
        metavar="NAME",
        autocompletion=REWARDS,
    ),
]
Ranges = Annotated[
    Names,
    typer.Option(
        help="The ranges to search: gamma=0.9..0.999, learning_rate=1e-4..1e-2:log, net_arch=64x64|256x256.",
        show_default="learning_rate and gamma",
        metavar="KEY=SPACE",
    ),
]
Trials = Annotated[
    int | None, typer.Option(help="How many settings (trials) each search tries.", show_default="20", metavar="N")
]
Seeds = Annotated[
    int | None,
    typer.Option(help="How often each setting is trained with each reward.", show_default="2", metavar="N"),
]
Steps = Annotated[
    int | None, typer.Option(help="Environment steps of each training.", show_default="10000", metavar="N")
]
ValidationEpisodes = Annotated[
    int | None,
    typer.Option(help="Episodes of the validation that judges each policy.", show_default="100", metavar="N"),
]
PerReward = Annotated[
    bool | None, typer.Option("--per-reward/--joint", help="Search once for each reward, or once for all together.")
]
Pruner = Annotated[
    str | None,
    typer.Option(help="What ends bad trials early: median or none.", show_default="median", metavar="NAME"),
]
Batch = Annotated[
    int | None,
    typer.Option(
        help="How many trials are drawn together, so that they can run at once.", show_default="1", metavar="N"
    ),
]
Seed = Annotated[
    int | None, typer.Option(help="The seed for drawing settings from the ranges.", show_default="0", metavar="S")
]
OutFolder = Annotated[
    Path | None, typer.Option(help="The tuning's folder.", show_default="one under results/runs/", metavar="DIR")
]
