"""``harness compare``: what changed from one experiment to another."""

from pathlib import Path
from typing import Annotated

import typer

from harness.cli.flags.shared import AsJson
from harness.cli.output import complain, say_json
from harness.cli.records import records_in

REGRESSION = 1


def compare(
    before: Annotated[Path, typer.Argument(help="The folder of the first experiment.", metavar="BEFORE")],
    after: Annotated[Path, typer.Argument(help="The folder of the second.", metavar="AFTER")],
    as_json: AsJson = False,
) -> int:
    """Compare two experiments that trained the same cells, for example before and after a plugin was edited.

    Ends with status 1 if a statistical test finds that policies of a proposed reward do worse than before.
    """
    from harness.cli.terminal import show
    from harness.report.tables.two_experiments import between_table
    from harness.results import load_results
    from harness.results.two_experiments import between

    for folder in (before, after):
        if (records := records_in([folder])) is not None:
            records.refuse(folder, "harness compare")
    both = load_results(before), load_results(after)
    found = between(*both)
    if as_json:
        say_json(found.to_json())
    else:
        show(between_table(found))
    if found.regressions:
        complain(f"regressions: {len(found.regressions)}; these policies do worse than before")
    return REGRESSION if found.regressions else 0
