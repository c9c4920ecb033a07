"""What is only ahead so far is called so, and by no other word, wherever a report is shown."""

import json
import re

import pytest

from harness.report import FactsTable, Report, what_decides, write_html
from harness.report.page.html import PROMISE
from tests.report.conftest import printed, squeezed, words_of
from tests.report.test_views import AHEAD

PLAIN = re.compile(r"\b(HELPS|HURTS|helps|hurts|LEARNS|learns (faster|slower|more slowly))\b")


@pytest.fixture
def ahead(build):
    """Results that labels dealt anew tell apart, and no bound."""
    results = build(seeds=6, reached=AHEAD)
    (combination,) = results.combinations
    assert combination.answer.ruling.is_ahead
    return results


def _shown(results, page):
    write_html(Report(results), page)
    text = page.read_text()
    yield "terminal", printed(FactsTable(Report(results).short), 200)
    yield "details", printed(FactsTable(Report(results).full), 200)
    yield "page", words_of(text)
    yield "colours", " ".join(re.findall(r'class="((?:card|badge|symbol|dot|line)[^"]*)"', text))
    yield "json", json.dumps(results.to_json())
    yield "notebook", results.combinations[0]._repr_html_()


def test_no_plain_word_stands_anywhere(ahead, tmp_path, subtests):
    """But in what explains both words."""
    explained = (what_decides(ahead), PROMISE)
    for name, shown in _shown(ahead, tmp_path / "page.html"):
        with subtests.test(name):
            text = squeezed(shown)
            for it in explained:
                text = text.replace(squeezed(it), "")
            assert "ahead" in text.lower()
            assert not PLAIN.search(text)
            assert name != "colours" or not re.search("better|worse", text)
