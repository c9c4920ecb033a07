"""``harness verify``: whether a folder still is what was written, and with ``--repair`` making it so."""

from pathlib import Path
from typing import Annotated

import typer

from harness.cli.flags.shared import AsJson, ExperimentFolder
from harness.cli.output import say, say_json
from harness.errors import UsageError
from harness.text import command_text

UNSOUND = 1
Repair = Annotated[
    bool,
    typer.Option(
        "--repair", help="Set aside what is damaged, and repair the plan. harness run then trains what is missing."
    ),
]


def verify(folder: ExperimentFolder, repair: Repair = False, as_json: AsJson = False) -> int:
    """Name every damaged file of an experiment. Such a file has changed since it was written.

    Without --repair it changes nothing.
    """
    if repair:
        if as_json:
            raise UsageError("--repair and --json: a repair prints no JSON. Repair first, then verify with --json")
        return set_aside(folder)
    from harness.experiment.verify import missing_cells, verify as find_problems

    problems, (missing, planned, note) = find_problems(folder), missing_cells(folder)
    if as_json:
        told = {"format": 1, "problems": [problem.to_json() for problem in problems]}
        say_json({**told, "cells": planned, "missing": missing, "recovered": note})
        return UNSOUND if problems else 0
    if note:
        say(note)
    if missing:
        say(f"Cells of the plan that are not here: {missing} of {planned}, not run yet or taken away")
    if problems:
        for problem in problems:
            say(f"{problem.path}: {problem.what}. What to do: {problem.remedy}.")
        say(f"{command_text('harness', 'verify', folder, '--repair')} sets aside what is damaged")
    else:
        say(f"No file of '{folder}' is damaged")
    return UNSOUND if problems else 0


def set_aside(folder: Path) -> int:
    """Set aside the damaged files of an experiment, repair its plan, and say what was done.

    Raises:
        UsageError: The folder is no experiment's, or another run is using it.
        SchemaError: The plan is damaged, and the cells do not tell what it was.
    """
    from harness.experiment.verify import repair as mend

    actions = mend(folder)
    for path, told in actions:
        say(f"{path}: {told}")
    if not actions:
        say(f"No file of '{folder}' is damaged: there is nothing to repair")
    return 0
