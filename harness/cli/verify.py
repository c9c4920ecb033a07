"""``harness verify`` and ``harness repair``: whether a folder still is what was written, and making it so."""

import json
from pathlib import Path
from typing import Annotated

import typer

from harness.cli.lines import say

Folder = Annotated[Path, typer.Argument(help="The experiment's folder.", metavar="DIR")]
UNSOUND = 1


def verify(
    folder: Folder, as_json: Annotated[bool, typer.Option("--json", help="Print JSON on standard output.")] = False
) -> int:
    """Name every file in an experiment's folder that is not what was written there. Changes nothing."""
    from harness.record.verify import verify as find_problems

    problems = find_problems(folder)
    if as_json:
        typer.echo(json.dumps({"format": 1, "problems": [problem.to_json() for problem in problems]}, indent=1))
    elif problems:
        for problem in problems:
            say(f"{problem.path}: {problem.what}. What to do: {problem.remedy}.")
        say(f"harness repair '{folder}' sets aside what is damaged")
    else:
        say(f"'{folder}' is what was written")
    return UNSOUND if problems else 0


def repair(folder: Folder) -> None:
    """Set aside what is damaged in an experiment's folder, and mend its plan; `harness run` then does the rest."""
    from harness.record.verify import repair as mend

    actions = mend(folder)
    for action in actions:
        say(f"{action.path}: {action.what}")
    if not actions:
        say(f"'{folder}' is what was written: there is nothing to repair")
