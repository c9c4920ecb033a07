"""The flags of ``harness audit`` that no other command has."""

from pathlib import Path
from typing import Annotated

import typer

from harness.authoring.commands import REWARDS, SIMULATORS, names_of

Subject = Annotated[
    str | None,
    typer.Argument(
        help="A task, such as fd100-reach; an environment, such as gymnasium:id=Pendulum-v1; the folder of an "
        "experiment, of recorded trainings or of other logs; or a data set: minari:NAME, lerobot:FOLDER, d4rl:FILE or "
        "robomimic:FILE.",
        metavar="[TASK|ENVIRONMENT|FOLDER|DATASET]",
        show_default="fd100-reach",
        autocompletion=names_of("tasks", "environments"),
    ),
]
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
        show_default="baseline, or the environment's",
        metavar="NAME",
        autocompletion=REWARDS,
    ),
]
Episodes = Annotated[
    int | None,
    typer.Option(
        help="Episodes of each scripted policy; in an environment of random actions, in each of 5 measurements.",
        show_default="100; 10 in an environment",
        metavar="N",
    ),
]
Gamma = Annotated[
    float | None,
    typer.Option(
        help="The discount factor of the learner, per step.", show_default="0.95; 0.99 in an environment", metavar="G"
    ),
]
Budget = Annotated[
    int | None,
    typer.Option(
        help="About so many steps are taken to look for what each reward pays most; 0: nothing is looked for.",
        metavar="STEPS",
        show_default="as many as take seconds, or a minute in an environment",
    ),
]
Starts = Annotated[
    int | None,
    typer.Option(help="From so many starts it is looked for.", metavar="N", show_default="8; 4 in an environment"),
]
SearchSeed = Annotated[int, typer.Option("--seed", help="Of the search: the same one finds the same.", metavar="N")]
FromFolders = Annotated[
    list[Path] | None,
    typer.Option(
        "--from",
        help="Behaviour that the search begins from: a folder of recorded trainings. May be repeated.",
        metavar="FOLDER",
        show_default=False,
    ),
]
PolicyNames = Annotated[
    list[str] | None,
    typer.Option(
        "--policy",
        help="The same: a function in a file, from an observation to an action. May be repeated.",
        metavar="FILE.py:NAME",
        show_default=False,
    ),
]
RandomFolder = Annotated[
    Path | None,
    typer.Option(
        help="A folder of recordings with random actions, to compare recorded trainings with.",
        metavar="FOLDER",
        show_default=False,
    ),
]
Success = Annotated[
    str | None,
    typer.Option(
        help="What says whether a step, or an episode, was a success: of an environment a measure or a key of info, of "
        "a data set a key, column or attribute; with a threshold where it is a number, 'KEY>0.5'.",
        metavar="KEY[>NUMBER]",
        show_default="a measure that is 0 or 1, success, is_success or next.success",
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
    Path | None,
    typer.Option(
        help="Write the page of a search, or of a data set, to this file.", metavar="FILE", show_default=False
    ),
]
OutFolder = Annotated[
    Path | None,
    typer.Option(
        help="Write a certificate of each behaviour that the search shows, and their page, to this folder.",
        metavar="FOLDER",
        show_default=False,
    ),
]
ReplayFile = Annotated[
    Path | None,
    typer.Option(
        help="Play a certificate again, and say whether it is paid the same, bit for bit; with --sim in another "
        "simulator.",
        metavar="FILE",
        show_default=False,
    ),
]
