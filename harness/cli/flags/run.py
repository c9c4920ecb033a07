"""The flags of ``harness run`` that no other command has."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from harness.cli.flags.shared import ALGORITHMS, REWARDS, TASKS, TRACKERS, Names

ExperimentFile = Annotated[
    Path | None,
    typer.Argument(help="Experiment file (TOML). Its keys are named like the flags; a flag overrides its key."),
]
TaskNames = Annotated[
    Names,
    typer.Option(
        "--task",
        help="Tasks, such as fd100-reach:epsilon=0.02, or environments, such as fetch-reach.",
        show_default="fd100-reach",
        metavar="NAME,...",
        autocompletion=TASKS,
    ),
]
AlgorithmNames = Annotated[
    Names,
    typer.Option(help="Algorithms, such as sac:learning_rate=1e-3.", metavar="NAME,...", autocompletion=ALGORITHMS),
]
Baseline = Annotated[
    str | None,
    typer.Option(
        help="The reward that the others are compared with.",
        show_default="baseline",
        metavar="NAME",
        autocompletion=REWARDS,
    ),
]
Seeds = Annotated[
    str | None, typer.Option(help="How many seeds, or a list of them (3,7,11).", show_default="6", metavar="N")
]
Steps = Annotated[
    int | None, typer.Option(help="Environment steps of training per cell.", show_default="5000", metavar="N")
]
EvaluateEvery = Annotated[
    int | None,
    typer.Option(
        help="Environment steps from one evaluation to the next.", show_default="only at the end", metavar="N"
    ),
]
Deterministic = Annotated[
    bool | None,
    typer.Option(
        "--deterministic/--stochastic",
        help="Evaluate policies without randomness, or let them draw their actions at random.",
        show_default="deterministic",
    ),
]
EvaluationHorizon = Annotated[
    int | None,
    typer.Option(
        help="In an environment: steps after which an episode of an evaluation is cut.",
        show_default="10000",
        metavar="N",
    ),
]
OutFolder = Annotated[
    Path | None,
    typer.Option(help="The experiment's folder.", show_default="one under results/runs/", metavar="DIR"),
]
CheckpointEvery = Annotated[
    int | None,
    typer.Option(
        help="Environment steps between checkpoints. A killed cell goes on from its last one. 0: no checkpoints.",
        show_default="every ten minutes",
        metavar="N",
    ),
]
TrackerNames = Annotated[
    Names,
    typer.Option(
        help="Also send the learning curves to a tracker, such as wandb:mode=offline.",
        show_default="nowhere",
        metavar="NAME,...",
        autocompletion=TRACKERS,
    ),
]
Tensorboard = Annotated[bool, typer.Option("--tensorboard", help="Short for --tracker tensorboard.")]
Wandb = Annotated[bool, typer.Option("--wandb", help="Short for --tracker wandb.")]
Mlflow = Annotated[bool, typer.Option("--mlflow", help="Short for --tracker mlflow.")]
Wait = Annotated[
    bool, typer.Option("--wait/--no-wait", help="If another run is using the folder: wait for it, or give up.")
]
Changed = Annotated[
    Literal["refuse", "keep", "again"],
    typer.Option(
        help="If a plugin has changed since cells were done: refuse to run, keep these cells, or train them again."
    ),
]
Only = Annotated[
    str | None,
    typer.Option(
        help="Run only the cells that these words describe, such as sac,seed=3.", show_default="all", metavar="NAME,..."
    ),
]
Limit = Annotated[int | None, typer.Option(help="Run at most this many cells.", show_default="all", metavar="N")]
RetryFailed = Annotated[
    int, typer.Option(help="How many times to try a failed cell again.", show_default="never", metavar="N")
]
FailFast = Annotated[bool, typer.Option("--fail-fast", help="Stop at the first cell that fails.")]
StallAfter = Annotated[
    float, typer.Option(help="End a cell that makes no progress for this many seconds. 0: never.", metavar="SECONDS")
]
CellTime = Annotated[
    float, typer.Option(help="The most seconds that a cell may take.", show_default="no limit", metavar="SECONDS")
]
CellMemory = Annotated[
    float, typer.Option(help="The most memory that a cell may use, in GiB.", show_default="no limit", metavar="GIB")
]
Fresh = Annotated[bool, typer.Option("--fresh", help="Start a new process for every cell.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="Show no progress, only the results.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print the results as JSON on standard output.")]
DryRun = Annotated[
    bool, typer.Option("--dry-run", help="Say what would be run, and how long it would take. Writes nothing.")
]
