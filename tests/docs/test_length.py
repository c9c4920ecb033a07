"""How long the pages are, and their sentences: what is long is not read."""

import re

import pytest

from tests.docs.pages import FENCE, PAGES, ROOT

DOCS = {page: page.read_text() for page in PAGES if ROOT / "docs" in page.parents}
MOST_WORDS = 46_000
LONGEST_MEAN = 12.0
END = re.compile(r"(?<=[.!?])[*\")]*\s+(?=[A-Z\"*`\[(0-9])")


def words(text):
    """What has a letter or a digit between blanks, code and tables included."""
    return len(re.findall(r"\S*[A-Za-z0-9]\S*", text))


def sentences(page):
    """The sentences of a page without code, tables, headings and pictures; each item of a list begins one."""
    prose = re.sub(r"^ *\|.*$|^#.*$|^ {4,}\S.*$|^!\[.*$", "", FENCE.sub("", page), flags=re.MULTILINE)
    prose = re.sub(r"\]\([^)]*\)", "]", prose)
    prose = re.sub(r"`[^`]*`", "`code`", prose)  # a command or a name is one word
    for paragraph in re.split(r"\n\s*\n|\n(?= *(?:[*-]|\d+\.) )", prose):
        text = re.sub(r"^ *(?:[*-]|\d+\.) +", "", " ".join(paragraph.split()))
        yield from (it for it in END.split(text) if words(it))


def mean_length(texts):
    """Words of a sentence on average."""
    found = [words(it) for text in texts for it in sentences(text)]
    return sum(found) / len(found)


def test_pages_are_short_together():
    """Of ``docs``, without what is made from the code."""
    assert sum(map(words, DOCS.values())) <= MOST_WORDS


def test_sentences_are_short():
    """On average over all pages."""
    assert mean_length(list(DOCS.values())) <= LONGEST_MEAN


@pytest.mark.parametrize(
    ("page", "count"),
    [
        ("One two. Three four five.", [2, 3]),
        ("# Head\n\n* One two\n* Three: `a b c` four\n", [2, 3]),
        ("| a | b |\n\n```\ncode\n```\n\nSee [one two](a/b.md). Then 3.5 % more.", [3, 3]),
    ],
)
def test_sentences_are_found(page, count):
    """Code, tables and headings are none; a number has no end in it."""
    assert [words(it) for it in sentences(page)] == count
