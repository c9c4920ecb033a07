"""The page of a data set links each wrongly ranked pair to its curves."""

import re
from pathlib import Path

from harness_plugins.audit.dataset.audit_dataset import audit_dataset
from harness_plugins.audit.dataset.page import write_dataset_page
from tests.record.dataset.written import episode, write_minari


def _page(tmp_path: Path) -> str:
    folder = write_minari(tmp_path / "d", [episode(9, number, number % 2 == 1) for number in range(16)])
    found = audit_dataset(f"minari:{folder}", {"<b>": lambda o, a, n, i: float(n[0]), "two": lambda o, a, n, i: 1.0})
    write_dataset_page(found, tmp_path / "page.html")
    return (tmp_path / "page.html").read_text()


def test_every_link_has_its_curves(tmp_path: Path):
    """A figure with two lines."""
    page = _page(tmp_path)
    links = re.findall(r'href="#(pair-[\d-]+)"', page)
    assert links
    assert all(f'<figure id="{link}">' in page for link in links)


def test_names_are_no_markup(tmp_path: Path):
    """Whatever they are."""
    page = _page(tmp_path)
    assert "<b>" not in page
    assert "&lt;b&gt;" in page


def test_nothing_comes_from_elsewhere(tmp_path: Path):
    """It opens offline."""
    page = _page(tmp_path)
    assert "default-src 'none'" in page
    assert "<script" not in page


def test_each_reward_has_its_answer_in_a_sentence(tmp_path: Path):
    """With a badge; its interval stands in the table."""
    page = _page(tmp_path)
    leads = re.findall(
        r'<span class="badge ([\w-]+)">([A-Z ]+)</span> (?:&lt;b&gt;|two)</h2>\n<p class="lead">([^<]*)</p>', page
    )
    assert len(leads) == 2
    for badge, answer, lead in leads:
        assert badge == {"RANKS AS SUCCESS DOES": "helps", "RANKS AGAINST IT": "hurts"}.get(answer, "cannot-tell")
        assert lead.startswith("A success is paid more than a failure with a chance of ")
        assert "[" not in lead
