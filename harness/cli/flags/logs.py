"""The flags of commands that open logs of trainings which anybody left."""

from pathlib import Path
from typing import Annotated

from harness.cli.flags.shared import flag, names_of

AsFormat = Annotated[
    str | None,
    flag(
        "FORMAT",
        "The format of logs, with its settings: table:success=is_success.",
        "found out",
        name="--as",
        offers=names_of("logs"),
    ),
]
SortBy = Annotated[
    str | None,
    flag(
        "TEMPLATE",
        "How names of logs are made, such as '{reward}/{seed}' or '*_{reward}_s{seed}'. What it fits is one "
        "training: '{reward}' says that all files of a folder are one. 'base_{seed}|{reward}' tells two kinds.",
        "what differs: a number is the seed",
        name="--sort",
    ),
]
LabelsFile = Annotated[
    Path | None,
    flag(
        "FILE",
        "Of logs: a CSV file with the columns run and success, or run, episode and success. A run is REWARD/SEED. Of a "
        "data set: one with the columns episode and success.",
        False,
        name="--labels",
    ),
]
LeftOut = Annotated[
    list[Path] | None,
    flag(
        "PATH",
        "A training that is left out, by its file or folder; can be repeated. A verdict waits for every other one that "
        "failed or stopped early.",
        False,
        name="--leave-out",
    ),
]
StepsOfEach = Annotated[
    str | None,
    flag(
        "REWARD=N,...",
        "Of logs that count iterations: how many environment steps one is, for each reward.",
        False,
        name="--per-step",
    ),
]
DecidedBy = Annotated[
    str | None,
    flag(
        "NAME",
        "Of logs: what decides, such as success or length:better=lower. return decides where one and the same "
        "reward paid all of them.",
        "success",
        name="--measure",
    ),
]
EndsOf = Annotated[
    list[str] | None,
    flag(
        "NAME=LEAST,GREATEST",
        "How bad and how good a training can be by a measure, such as score=0,200; can be repeated. HELPS and HURTS "
        "need to know it.",
        False,
        name="--ends",
    ),
]
BaselineName = Annotated[
    str | None,
    flag(
        "NAME",
        "Of logs and recorded trainings: the reward that the others are compared with.",
        "one called base",
        name="--baseline",
    ),
]
