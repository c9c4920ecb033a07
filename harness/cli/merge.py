"""``harness merge``: folders of several machines become one."""

from pathlib import Path
from typing import Annotated

import typer

from harness.cli.flags.shared import flag
from harness.cli.output import complain, say

LEFT_OUT = 1


def merge(
    folders: Annotated[list[Path], typer.Argument(help="Folders of experiments.", metavar="DIR...")],
    out: Annotated[Path, flag("DIR", "A new folder, or the folder of an experiment that the cells are added to.")],
) -> int:
    """Put the cells of several experiments' folders into one, as if one run had done them. Changes no other folder."""
    from harness.cli.output import make_table_and_page
    from harness.record.merge import merge as put_together
    from harness.record.store import CELLS
    from harness.results.compare import mixtures_of
    from harness.results.load import load_results

    merged = put_together(folders, out)
    results = load_results(out)
    for told in filter(None, (merged.plan.note, *(it.text for it in mixtures_of(results.done)))):
        complain(told)
    for path, reason in merged.left_out:
        complain(f"left out: {path}: {reason}")
    cells = sum(place.parts[0] == CELLS for place in merged.taken)
    say(f"Merged:  {cells} of {len(merged.plan.cells)} cells have ended")
    make_table_and_page(results)
    return LEFT_OUT if merged.left_out else 0
