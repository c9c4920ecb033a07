"""The flags of ``harness audit`` that no other command has."""

from pathlib import Path
from typing import Annotated

import typer

from harness.cli.flags.shared import REWARDS, SIMULATORS, TASKS, flag

Subject = Annotated[
    str | None,
    typer.Argument(
        help="A task, such as fd100-reach; an environment, such as gymnasium:id=Pendulum-v1; the folder of an "
        "experiment, of recorded trainings or of other logs; or a data set: minari:NAME, lerobot:FOLDER, d4rl:FILE or "
        "robomimic:FILE.",
        metavar="[TASK|ENVIRONMENT|FOLDER|DATASET]",
        show_default="fd100-reach",
        autocompletion=TASKS,
    ),
]
RewardName = Annotated[str | None, flag("NAME,...", "The reward, such as arp:k2=2, or several.", False, offers=REWARDS)]
SimulatorName = Annotated[
    str | None,
    flag("NAME", "The simulator. Without one the joints move exactly as commanded.", offers=SIMULATORS),
]
Against = Annotated[
    str | None,
    flag(
        "NAME",
        "The reward to compare with: how far apart the two are.",
        "baseline, or the environment's",
        offers=REWARDS,
    ),
]
Episodes = Annotated[
    int | None,
    flag(
        "N",
        "Episodes of each scripted policy; in an environment of random actions, in each of 5 measurements.",
        "100; 10 in an environment",
    ),
]
Gamma = Annotated[
    float | None, flag("G", "The discount factor of the learner, per step.", "0.95; 0.99 in an environment")
]
Budget = Annotated[
    int | None,
    flag(
        "STEPS",
        "About so many steps are taken to look for what each reward pays most; 0: nothing is looked for.",
        "as many as take seconds, or a minute in an environment",
    ),
]
Starts = Annotated[int | None, flag("N", "From so many starts it is looked for.", "8; 4 in an environment")]
SearchSeed = Annotated[int, flag("N", "Of the search: the same one finds the same.", name="--seed")]
FromFolders = Annotated[
    list[Path] | None,
    flag(
        "FOLDER",
        "Behaviour that the search begins from: a folder of recorded trainings. May be repeated.",
        False,
        name="--from",
    ),
]
PolicyNames = Annotated[
    list[str] | None,
    flag(
        "FILE.py:NAME",
        "The same: a function in a file, from an observation to an action. May be repeated.",
        False,
        name="--policy",
    ),
]
RandomFolder = Annotated[
    Path | None,
    flag("FOLDER", "A folder of recordings with random actions, to compare recorded trainings with.", False),
]
Success = Annotated[
    str | None,
    flag(
        "KEY[>NUMBER]",
        "What says whether a step, or an episode, was a success: of an environment a measure or a key of info, of "
        "a data set a key, column or attribute; with a threshold where it is a number, 'KEY>0.5'.",
        "a measure that is 0 or 1, success, is_success or next.success",
    ),
]
LabelsFile = Annotated[
    Path | None,
    flag("FILE", "Of a data set: a CSV file with the columns episode and success, a line for each episode.", False),
]
SuccessAbove = Annotated[
    float | None,
    flag("RETURN", "Of a data set: the recorded return above which an episode is a success.", False),
]
Cluster = Annotated[
    str | None,
    flag(
        "KEY",
        "Of a data set: what says who made an episode, an attribute or a column; or file.",
        "operator, else each episode by itself",
    ),
]
Beginner = Annotated[str | None, flag("DATASET", "Another data set, of which episodes should be paid less.", False)]
HtmlFile = Annotated[Path | None, flag("FILE", "Write the page of a search, or of a data set, to this file.", False)]
OutFolder = Annotated[
    Path | None,
    flag(
        "FOLDER",
        "Write a certificate of each behaviour that the search shows, and their page, to this folder.",
        False,
    ),
]
ReplayFile = Annotated[
    Path | None,
    flag(
        "FILE",
        "Play a certificate again, and say whether it is paid the same, bit for bit; with --sim in another simulator.",
        False,
    ),
]
