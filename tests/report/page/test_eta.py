"""Recorded runs compared, as a page."""

import re
from dataclasses import replace

import pytest

from harness.report import write_eta_page
from harness.report.page.eta import draw_groups
from harness.report.page.page import to_html


def read_page(comparison, path):
    """The page, written and read."""
    pytest.importorskip("jinja2")
    write_eta_page(comparison, path)
    return path.read_text()


def test_every_run_and_both_means_are_drawn(compare):
    """A thin line each, and a thick one per group, which alone are in the legend."""
    lines = draw_groups(compare()).marks
    assert [line.name for line in lines] == [
        "baseline run 1", "baseline run 2", "baseline, mean of 2",
        "proposed run 1", "proposed run 2", "proposed, mean of 2",
    ]  # fmt: skip
    assert [line.width > 1 for line in lines] == [line.in_legend for line in lines]
    assert lines[2].y == [0.0, -1.0, -0.5, 0.0, 0.75]
    assert lines[5].y == [0.0, -0.5, 0.25, 1.375, 2.6875]


def test_axis_says_which_curve(compare):
    """And the lines are that one."""
    chart = draw_groups(compare(kind="per-step"))
    assert chart.y.title == "per-step reward"
    assert chart.marks[2].y == [0.0, -1.0, 0.5, 0.5, 0.75]


def test_page_is_whole_and_loads_nothing(compare, tmp_path):
    """The figure is in it, and a policy forbids the rest; the template is that of every report."""
    page = read_page(compare(), tmp_path / "eta.html")
    assert "default-src 'none';" in page
    assert not re.search(r"<(link|img|iframe|object|embed) ", page)
    assert all(link.startswith("#") for link in re.findall(r'href="([^"]*)"', page))
    assert page.count('<path class="line ') == 6 + 2  # two samples in the legend


def test_page_has_the_number_in_words(compare, tmp_path):
    """And which rewards and how many runs were compared."""
    comparison = compare()
    page = read_page(comparison, tmp_path / "eta.html")
    assert "CANNOT TELL" in page
    for told in (comparison.number, "proposed arp:k1=1,k2=1.5 against baseline", "baseline 2 runs, proposed 2 runs"):
        assert to_html(told) in page


def test_labels_are_escaped(compare, tmp_path):
    """A reward's label is text."""
    given = replace(compare(), rewards={"baseline": "<script>alert(1)</script>", "proposed": "arp"})
    assert "<script>alert" not in read_page(given, tmp_path / "eta.html")
