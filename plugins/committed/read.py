"""Reports from the committed records that ``harness report DIR --summary FOLDER`` leaves. They need no cell."""

from pathlib import Path
from typing import NotRequired

from rich.console import Group, RenderableType
from rich.markdown import Markdown
from rich.text import Text
from typing_extensions import TypedDict

from harness.errors import UsageError
from harness.files import reading
from harness.files.bounded import parse_json, read_bytes
from harness.record import EXPERIMENT, PLAN
from harness.record.file_forms import read_form
from harness.report import Fact, FactsTable
from harness.text import command_text

RECORD, SUMMARY = "results.json", "summary.md"
MOST_BYTES = 64 * 2**20


class CellForm(TypedDict):
    """What is read of a cell."""

    status: str


class RecordForm(TypedDict):
    """What is read of a record: its facts, which one of an earlier release lacks."""

    cells: list[CellForm]
    facts: NotRequired[list[Fact]]


def is_committed(folder: Path) -> bool:
    """Whether a folder holds records, but no experiment."""
    return (folder / RECORD).is_file() and not (folder / PLAN).exists()


def committed_text(folder: Path) -> str:
    """The records as JSON.

    Raises:
        SchemaError: The file is damaged.
    """
    with reading(folder / RECORD, "record"):
        return read_bytes(folder / RECORD, MOST_BYTES).decode("utf-8").rstrip("\n")


def committed_table(folder: Path) -> RenderableType:
    """What the report said first when the records were written; of an earlier release its page of text.

    Raises:
        SchemaError: A file is damaged.
    """
    with reading(folder / RECORD, "record"):
        record = read_form(RecordForm, parse_json(read_bytes(folder / RECORD, MOST_BYTES)))
        for grid in (it for fact in record.get("facts", []) for way in (fact.grids, *fact.narrower) for it in way):
            if {*map(len, grid.rows)} - {len(grid.headings)}:
                raise ValueError(f"a row of '{grid.title}' is not as long as its headings")
    done = sum(cell["status"] == "done" for cell in record["cells"])
    head = Text(f"Committed records of {len(record['cells'])} cells, {done} done.\n")
    facts = record.get("facts")
    if facts is None:
        with reading(folder / SUMMARY, "record"):
            told: RenderableType = Markdown(read_bytes(folder / SUMMARY, MOST_BYTES).decode("utf-8"), hyperlinks=False)
    else:
        told = FactsTable(facts)
    return Group(head, told, Text(), Text(_more(folder)))


def refuse_committed(folder: Path, flag: str) -> None:
    """Refuse a flag that needs cells, and say what can be done instead.

    Raises:
        UsageError: The folder holds records alone.
    """
    if is_committed(folder):
        raise UsageError(f"{flag} needs cells, and '{folder}' holds only records. {_more(folder)}")


def _more(folder: Path) -> str:
    return (
        f"All numbers and figures: {folder / SUMMARY}. To train its cells again, for the page and the replay: "
        + command_text("harness", "run", folder / EXPERIMENT, "--out", "NEW")
    )
