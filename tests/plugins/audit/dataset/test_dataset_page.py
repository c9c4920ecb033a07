"""The page of a data set links each wrongly ranked pair to its curves."""

import re

import pytest

from harness_plugins.audit import audit_dataset
from harness_plugins.audit.dataset.page import write_dataset_page
from tests.record.dataset.written import episode, write_minari


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """Of two rewards, one of which is called as markup is."""
    place = tmp_path_factory.mktemp("page")
    folder = write_minari(place / "d", [episode(9, number, number % 2 == 1) for number in range(16)])
    found = audit_dataset(f"minari:{folder}", {"<b>": lambda o, a, n, i: float(n[0]), "two": lambda o, a, n, i: 1.0})
    write_dataset_page(found, place / "page.html")
    return (place / "page.html").read_text()


def test_every_link_has_its_curves(page):
    """A figure with two lines."""
    links = re.findall(r'href="#(pair-[\d-]+)"', page)
    assert links
    assert all(f'<figure id="{link}">' in page for link in links)


def test_names_are_no_markup_and_nothing_comes_from_elsewhere(page):
    """Whatever they are; it opens offline."""
    assert "&lt;b&gt;" in page
    assert "default-src 'none'" in page
    assert not re.search("<b>|<script", page)


def test_each_reward_has_its_answer_in_a_sentence(page):
    """With a badge; its interval stands in the table."""
    leads = re.findall(
        r'<span class="badge ([\w-]+)">([A-Z ]+)</span> (?:&lt;b&gt;|two)</h2>\n<p class="lead">([^<]*)</p>', page
    )
    assert len(leads) == 2
    for badge, answer, lead in leads:
        assert badge == {"RANKS AS SUCCESS DOES": "helps", "RANKS AGAINST IT": "hurts"}.get(answer, "cannot-tell")
        assert lead.startswith("A success is paid more than a failure with a chance of ")
        assert "[" not in lead
