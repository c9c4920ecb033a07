"""Every figure of the pages, and every table of measurements, comes from a record or a command that is named."""

import re
import tomllib
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.docs.pages import FENCE, PAGES, ROOT

PICTURES = ROOT / "docs" / "pictures"
SOURCES = tomllib.loads((PICTURES / "sources.toml").read_text())
FIGURE = re.compile(r"!\[[^]]*\]\(([^)\s]+)\)")
COMMAND = re.compile(r"\bharness [a-z]+|\bmake [a-z]+|\bpython docs/|^drawn by hand: ")
NAMED = re.compile(
    r"results/reference/[\w./-]+|\bharness (?:run|parity|audit|eta|report|check|choose|transfer)\b[^\n|]*|"
    r"\bmake (?:reference|bench|wheel)\b|\bpytest\b|tests/[\w/]+\.py|experiments/[\w./-]+"
)
"""What tells where numbers come from: a record, a command, a test, an experiment file."""
TABLE = re.compile(r"^ *\|[^\n]*\n *\|[ :|-]+\n(?: *\|[^\n]*\n)+", re.MULTILINE)
VALUE = re.compile(r"[-+x]?\s?\*{0,2}\d[\d,]*(?:\.\d+)?(?:e[-+]?\d+)?(?: ?%)?\*{0,2}(?: (?:s|mm|ms|points|GB|us|x)\b)?")
MEASURED = 0.34
"""A table is one of measurements if this share of its cells has a number and next to nothing else."""


class Table(NamedTuple):
    """A table of measurements, and the text in which its source has to stand: its section, and the page's beginning."""

    place: str
    head: str
    text: str


def is_value(cell):
    """Whether a cell is a number, several of them, or an interval."""
    left = re.sub(r"[\s\[\](),/;x°]|against|and|to|near zero|n/a|of|pp|p <", "", VALUE.sub("", cell))
    return bool(VALUE.search(cell)) and len(left) <= 2


def is_measured(table):
    """Whether a table is one of measurements, and not one of words, settings or defaults."""
    head, _, *rows = table.strip().splitlines()
    if re.search(r"\| (default|key|setting|parameter|published) +\|", head):
        return False
    cells = [cell.strip() for row in rows for cell in row.strip().strip("|").split("|")[1:]]
    return bool(cells) and sum(map(is_value, cells)) / len(cells) >= MEASURED


def tables_of(page, text):
    """The tables of measurements of a page."""
    hidden = FENCE.sub(lambda found: found[0].replace("|", "¦"), text)
    beginning, *sections = re.split(r"^(?=## )", hidden, flags=re.MULTILINE)
    return [
        Table(page, found[0].splitlines()[0], beginning + "\n" + section)
        for section in (beginning, *sections)
        for found in TABLE.finditer(section)
        if is_measured(found[0])
    ]


def without_source(tables):
    """Where no record and no command is named."""
    return [f"{it.place}: {it.head}" for it in tables if not NAMED.search(it.text)]


def strange_figures(page, text):
    """The figures of a page that are neither a record's nor one whose source is told."""
    paths = [(page.parent / link).resolve().relative_to(ROOT) for link in FIGURE.findall(FENCE.sub("", text))]
    known = {Path("docs/pictures") / name for name in SOURCES}
    return [path.as_posix() for path in paths if path not in known and path.parts[:2] != ("results", "reference")]


OF_SITE = [page for page in PAGES if page == ROOT / "README.md" or ROOT / "docs" in page.parents]
TABLES = [it for page in OF_SITE for it in tables_of(page.relative_to(ROOT).as_posix(), page.read_text())]


def test_every_table_of_measurements_names_its_source():
    """A record, a command, a test or an experiment file, in its section or where the page begins."""
    assert len(TABLES) > 25
    assert without_source(TABLES) == []


def test_every_figure_comes_from_somewhere(subtests):
    """From a record, or from a command that ``docs/pictures/sources.toml`` names."""
    for page in PAGES:
        with subtests.test(page=page):
            assert strange_figures(page, page.read_text()) == []


def test_every_picture_has_a_source_and_every_source_a_picture():
    """Also one that no page shows."""
    assert {path.name for path in PICTURES.iterdir() if path.suffix in {".png", ".gif", ".svg"}} == set(SOURCES)


def test_source_of_a_picture_is_a_command(subtests):
    """Or it says that somebody drew it."""
    for name, source in SOURCES.items():
        with subtests.test(name=name):
            assert COMMAND.search(source)


def test_every_picture_of_a_record_is_in_it():
    """The links lead to files that are committed; ``test_links`` looks whether they are there."""
    assert any("results/reference" in it for page in PAGES for it in FIGURE.findall(page.read_text()))


NUMBERS = "| reward | time | eta |\n| --- | --- | --- |\n| arp | 1.2 s | 0.800 [0.677, 0.946] |\n"


@pytest.mark.parametrize(
    ("text", "count"),
    [
        (f"# A\n\n{NUMBERS}", 1),
        (f"# A\n\n`make reference EXPERIMENT=a`\n\n## B\n\n{NUMBERS}", 0),
        (f"# A\n\n## B\n\nsee [it](../results/reference/a/summary.md)\n\n{NUMBERS}\n## C\n\n{NUMBERS}", 1),
        ("# A\n\n| word | what |\n| --- | --- |\n| seed | one of 3 numbers that are drawn |\n", 0),
        ("# A\n\n| key | default |\n| --- | --- |\n| a | 1 |\n", 0),
    ],
)
def test_table_without_a_source_is_found(text, count):
    """The mutants: numbers without a source, and one whose source stands in another section."""
    assert len(without_source(tables_of("page", text))) == count


def test_figure_from_nowhere_is_found():
    """The mutant: a picture that is in no record and has no source."""
    page = ROOT / "docs" / "page.md"
    assert strange_figures(page, "![a](pictures/gone.png) ![b](pictures/demo.png)") == ["docs/pictures/gone.png"]
