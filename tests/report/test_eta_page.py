"""Recorded runs compared, as a page."""

import json
import re
import sys
from dataclasses import replace

import pytest

from harness.errors import UsageError
from harness.report.eta_page import draw_groups, write_eta_page


def read_page(comparison, path):
    """The page, written and read."""
    pytest.importorskip("plotly")
    write_eta_page(comparison, path)
    return path.read_text(encoding="utf-8")


def test_every_run_and_both_means_are_drawn(compare):
    """A thin line each, and a thick one per group, which alone are in the legend."""
    lines = draw_groups(compare())["data"]
    assert [line["name"] for line in lines] == [
        "baseline run 1", "baseline run 2", "baseline, mean of 2",
        "proposed run 1", "proposed run 2", "proposed, mean of 2",
    ]  # fmt: skip
    assert [line["line"]["width"] > 1 for line in lines] == [line.get("showlegend", True) for line in lines]
    assert lines[2]["y"] == [0.0, -1.0, -0.5, 0.0, 0.75]
    assert lines[5]["y"] == [0.0, -0.5, 0.25, 1.375]


def test_axis_says_which_curve(compare):
    """And the lines are that one."""
    figure = draw_groups(compare(kind="per-step"))
    assert figure["layout"]["yaxis"]["title"]["text"] == "per-step reward"
    assert figure["data"][2]["y"] == [0.0, -1.0, 0.5, 0.5, 0.75]


def test_page_is_whole_and_loads_nothing(compare, tmp_path):
    """What draws the figure is in it, once, and a policy forbids the rest; the figure can be read."""
    comparison = compare()
    page = read_page(comparison, tmp_path / "eta.html")
    assert "default-src 'none'; script-src 'unsafe-inline'" in page
    assert page.count("* plotly.js v") == 1
    assert not re.search(r"<(link|img|iframe|object|embed)|<script src|<a href", page.split("* plotly.js v")[0])
    (figure,) = re.findall(r'<script type="application/json">(.*?)</script>', page, re.DOTALL)
    assert json.loads(figure) == draw_groups(comparison)


def test_page_has_the_number_in_words(compare, tmp_path):
    """And which rewards and how many runs were compared."""
    comparison = compare()
    page = read_page(comparison, tmp_path / "eta.html")
    for told in (comparison.number, "proposed arp:k1=1,k2=1.5 against baseline", "baseline 2 runs, proposed 2 runs"):
        assert told in page


def test_labels_are_escaped(compare, tmp_path):
    """A reward's label is text."""
    given = replace(compare(), rewards={"baseline": "<script>alert(1)</script>", "proposed": "arp"})
    assert "<script>alert" not in read_page(given, tmp_path / "eta.html")


def test_failed_write_leaves_the_old_page(compare, tmp_path, monkeypatch):
    """Whole, with nothing beside it: the page is written beside it and renamed."""

    def refuse(source, target):
        raise OSError(28, "No space left on device")

    folder = tmp_path / "pages"
    folder.mkdir()
    read_page(compare(), folder / "eta.html")
    before = (folder / "eta.html").read_bytes()
    monkeypatch.setattr("os.replace", refuse)
    with pytest.raises(UsageError, match=r"eta\.html' cannot be written: No space left on device"):
        write_eta_page(compare(kind="per-step"), folder / "eta.html")
    assert [file.name for file in folder.iterdir()] == ["eta.html"]
    assert (folder / "eta.html").read_bytes() == before


@pytest.mark.parametrize("library", ["jinja2", "plotly.offline"])
def test_missing_library_names_the_extra(compare, tmp_path, monkeypatch, library):
    """Nothing is written."""
    comparison = compare()
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(UsageError, match=r"pip install 'fd100-harness\[report\]'"):
        write_eta_page(comparison, tmp_path / "eta.html")
    assert not (tmp_path / "eta.html").exists()


def test_plotly_accepts_the_figure(compare):
    """Every property is one that plotly knows."""
    go = pytest.importorskip("plotly.graph_objects")
    assert len(go.Figure(draw_groups(compare())).data) == 6
