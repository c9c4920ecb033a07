"""``harness verify`` and ``harness repair``: whether a folder still is what was written, and making it so."""

from harness.cli.flags.shared import AsJson, ExperimentFolder
from harness.cli.output import say, say_json
from harness.text import command_text

UNSOUND = 1


def verify(folder: ExperimentFolder, as_json: AsJson = False) -> int:
    """Name every file in an experiment's folder that was damaged or changed since it was written. Changes nothing."""
    from harness.record.verify import missing_cells
    from harness.record.verify import verify as find_problems

    problems, (missing, planned) = find_problems(folder), missing_cells(folder)
    if as_json:
        told = {"format": 1, "problems": [problem.to_json() for problem in problems]}
        say_json({**told, "cells": planned, "missing": missing})
        return UNSOUND if problems else 0
    if missing:
        say(f"Cells of the plan that are not here: {missing} of {planned}, not run yet or taken away")
    if problems:
        for problem in problems:
            say(f"{problem.path}: {problem.what}. What to do: {problem.remedy}.")
        say(f"{command_text('harness', 'repair', folder)} sets aside what is damaged")
    else:
        say(f"No file of '{folder}' is damaged")
    return UNSOUND if problems else 0


def repair(folder: ExperimentFolder) -> None:
    """Set aside the damaged files of an experiment, and repair its plan. `harness run` then trains what is missing."""
    from harness.record.verify import repair as mend

    actions = mend(folder)
    for action in actions:
        say(f"{action.path}: {action.what}")
    if not actions:
        say(f"No file of '{folder}' is damaged: there is nothing to repair")
