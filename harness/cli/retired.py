"""Names of version 0.1 that still work in this one, each with a line that says the new name. No help shows them."""

from collections.abc import Mapping
from typing import Annotated

import typer

from harness.cli.flags.shared import ExperimentFolder
from harness.cli.output import complain
from harness.cli.verify import set_aside

TRACKERS = ("tensorboard", "wandb", "mlflow")
"""Each was a flag of ``harness run``."""
Tensorboard = Annotated[bool, typer.Option("--tensorboard", hidden=True)]
Wandb = Annotated[bool, typer.Option("--wandb", hidden=True)]
Mlflow = Annotated[bool, typer.Option("--mlflow", hidden=True)]


def repair(folder: ExperimentFolder) -> int:
    """The old name of ``harness verify --repair``."""
    _warn("harness repair", "harness verify --repair")
    return set_aside(folder)


def old_trackers(given: Mapping[str, object]) -> list[str]:
    """The trackers that were asked for by a flag of their own.

    Args:
        given: What was given for each flag, by its name.
    """
    names = [name for name in TRACKERS if given[name]]
    for name in names:
        _warn(f"--{name}", f"--tracker {name}")
    return names


def _warn(old: str, new: str) -> None:
    complain(f"{old} is now {new}. The old form works in this version only")
