"""docs/design.md: one page, and each name on it stands in the file that the page says."""

import re

from tests.project import ROOT, page_of

PAGE = page_of("design")
NAMED = re.compile(r"`(\w+)`\s+\(`([\w/]+\.py)`\)")


def misplaced(text):
    """Names, as in ``Log`` (``log/log.py``), that the file beside them does not define."""
    places = [(name, path) for name, path in NAMED.findall(text)]
    sources = {
        path: next(root / path for root in (ROOT / "harness", ROOT) if (root / path).exists()) for _, path in places
    }
    return [
        f"{name} ({path})"
        for name, path in places
        if not re.search(rf"^\s*(class|def) {name}\b|^{name}\b.*=", sources[path].read_text(), re.M)
    ]


def test_it_is_one_page():
    """Who does not know the code reads it in one sitting."""
    assert len(PAGE.splitlines()) <= 150


def test_five_questions_are_answered_with_names():
    """Where a step comes from, who pays it, writes it, compares, and says the sentence."""
    rows = [line for line in PAGE.split("## The rooms")[0].splitlines() if re.match(r"\| (Where|Who) ", line)]
    assert len(rows) == 5
    assert all(re.search(r"`[\w/]+(\.py|/)`", row) for row in rows)


def test_every_name_stands_where_the_page_says():
    """A class or function that moves takes its line on the page along."""
    assert len(NAMED.findall(PAGE)) >= 20
    assert misplaced(PAGE) == []


def test_a_name_that_moved_is_found():
    """The check itself."""
    assert misplaced("`Log` (`log/facts.py`), `Log` (`log/log.py`)") == ["Log (log/facts.py)"]
