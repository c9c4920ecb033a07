"""The figures of records that were written down earlier, drawn again by this version, from the records alone.

``python -m harness_plugins.committed.redraw FOLDER ...`` takes folders that ``harness report DIR --summary FOLDER``
wrote. Numbers and words stay as they are. What the page does not show is not drawn.
"""

import re
import sys
from pathlib import Path

from harness.authoring.commands import read_bytes, read_json, read_text, reading
from harness.errors import UsageError
from harness.text import one_line_of, print_visible

from .read import RECORD, SUMMARY
from .records import DRAWN, FIGURES, FORMAT, draw_figures, put_files
from .tables import RUNS, read_runs

RECORD_BYTES = 2**28
"""Most that is read of each file of a record."""
PICTURE = re.compile(r"^!\[[^]]*\]\((figures/[^)]+\.svg)\)$", re.MULTILINE)


def redraw(folder: Path) -> None:
    """Draw the figures of a record again. A figure that has nothing to show becomes words on the page, or goes.

    Raises:
        UsageError: The folder has no such record, one without the curves of its runs, a damaged one, or one of a newer
            version.
    """
    missing = [name for name in (RECORD, SUMMARY, DRAWN, RUNS) if not (folder / name).is_file()]
    if missing:
        raise UsageError(f"'{folder}' lacks {', '.join(missing)}: name a folder that `harness report --summary` wrote")
    with reading(folder, "record", UsageError):
        record, told = (read_json(folder / name, RECORD_BYTES) for name in (RECORD, DRAWN))
        if told["format"] > FORMAT:
            raise UsageError(f"'{folder / DRAWN}' was written by a newer version: update this one")
        drawn = draw_figures(record, told, read_runs(read_bytes(folder / RUNS, RECORD_BYTES)))
        page = read_text(folder / SUMMARY, RECORD_BYTES)
    shown = {path: svg for path, svg in drawn.files.items() if f"]({path})" in page}
    page = PICTURE.sub(lambda found: found[0] if found[1] in shown else drawn.words.get(found[1], ""), page)
    page = re.sub(r"\n{3,}", "\n\n", page)
    put_files(folder, {SUMMARY: page.encode(), **shown}, FIGURES)


if __name__ == "__main__":
    try:
        if not sys.argv[1:]:
            raise UsageError(
                "Name the folders whose figures are drawn: python -m harness_plugins.committed.redraw FOLDER ..."
            )
        for name in sys.argv[1:]:
            redraw(Path(name))
    except UsageError as error:
        print_visible(one_line_of(str(error)), err=True)
        sys.exit(2)
