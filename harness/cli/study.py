"""Recorded trainings in any env, as ``harness eta FOLDER`` and ``harness report FOLDER`` show them."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from harness.cli.flags.shared import Names
from harness.cli.lines import complain, say
from harness.errors import UsageError

if TYPE_CHECKING:
    from harness.eta.curve import Kind


def holds_recordings(folders: Sequence[Path]) -> bool:
    """Whether a folder holds recorded trainings, and no experiment.

    Raises:
        UsageError: So does one of several.
    """
    from harness.record.plan_file import PLAN
    from harness.results.recordings.runs import has_recordings

    found = [folder for folder in folders if not (folder / PLAN).exists() and has_recordings(folder)]
    if found and len(folders) > 1:
        raise UsageError(f"'{found[0]}' holds recorded trainings: name one folder that all of them lie in")
    return bool(found)


def refuse_flags(flags: Mapping[str, object]) -> None:
    """Say which flag cannot be used.

    Raises:
        UsageError: One was given.
    """
    for flag, given in flags.items():
        if given:
            raise UsageError(f"{flag} does not go with a folder of recorded trainings: leave it out")


def show_study(folder: Path, kind: "Kind", metric: Names, *, as_json: bool, html: Path | None, details: bool) -> int:
    """Write and print what is asked for; the exit status, 1 where a recording is damaged.

    Raises:
        UsageError: There is nothing that can be compared, or the page cannot be written.
    """
    from harness.cli.terminal import show
    from harness.report.trainings.document import study_json
    from harness.report.trainings.page import write_study_page
    from harness.report.trainings.table import study_overview, study_table
    from harness.results.recordings import load_study

    study = load_study(folder, kind, metric)
    if html is not None:
        write_study_page(study, html)
        say(f"Report: {html}", err=True)
    if as_json:
        typer.echo(study_json(study))
    elif details:
        show(study_table(study))
    elif html is None:
        show(study_overview(study, f"harness report {folder} --details"))
    for line in study.runs.damaged:
        complain(f"left out, damaged: {line}")
    return 1 if study.runs.damaged else 0
