"""The page: figures of every pair, tables, and nothing from elsewhere."""

import json
import re
import sys

import numpy as np
import pytest

from harness.errors import UsageError
from harness.parity.figure import draw_joints, draw_tips
from harness.parity.page import write_parity


@pytest.fixture(scope="module")
def found(compare, toolbox):
    """One that is right, one a millimetre off, one that is late."""
    return compare(right=toolbox.ideal, off=toolbox.shifted_tip(1e-3), late=toolbox.late)


def test_a_line_for_each_pair(found):
    """Those against the reference are shown, the others wait in the legend; no two look the same."""
    lines = draw_tips(found)["data"]
    assert [line["name"] for line in lines] == ["off against right", "late against right", "late against off"]
    assert [line["visible"] for line in lines] == [True, True, "legendonly"]
    assert len({(line["line"]["color"], line["line"]["dash"]) for line in lines}) == 3


def test_lines_are_in_millimetres_degrees_and_seconds(found):
    """The first pair's tips are 1 mm apart from the first moment to the last."""
    line = draw_tips(found)["data"][0]
    np.testing.assert_allclose(line["y"], 1.0)
    np.testing.assert_allclose(line["x"], np.arange(41) * 0.1)
    late = draw_joints(found)["data"][1]
    assert max(late["y"]) == pytest.approx(np.degrees(found.pairs[1].drift.max_joint_error_rad), rel=1e-5)
    assert "[mm]" in draw_tips(found)["layout"]["yaxis"]["title"]["text"]
    assert "[deg]" in draw_joints(found)["layout"]["yaxis"]["title"]["text"]


def test_without_the_reference_every_line_is_shown(compare, toolbox):
    """There is nothing else to show."""
    broken = compare(bad=toolbox.closed, one=toolbox.ideal, two=toolbox.late)
    assert [line["visible"] for line in draw_tips(broken)["data"]] == [True]


def test_the_page_is_whole_and_loads_nothing(found, tmp_path):
    """plotly.js once, two figures that can be read, the tables, and a policy that forbids the rest."""
    pytest.importorskip("plotly")
    write_parity(found, tmp_path / "parity.html")
    page = (tmp_path / "parity.html").read_text(encoding="utf-8")
    assert "default-src 'none'; script-src 'unsafe-inline'" in page
    assert page.count("* plotly.js v") == 1
    assert not re.search(r"<(link|img|iframe|object|embed)|<script src|<a href", page.split("* plotly.js v")[0])
    figures = re.findall(r'<script type="application/json">(.*?)</script>', page, re.DOTALL)
    assert [len(json.loads(figure)["data"]) for figure in figures] == [3, 3]
    assert page.count("<table>") == 3
    assert "late against off" in page


def test_names_cannot_inject(compare, toolbox, tmp_path):
    """What a simulator calls itself is text."""
    pytest.importorskip("plotly")
    found = compare(**{"<script>alert(1)</script>": toolbox.ideal, "b": toolbox.ideal})
    write_parity(found, tmp_path / "parity.html")
    assert "<script>alert" not in (tmp_path / "parity.html").read_text(encoding="utf-8")


def test_without_pairs_there_is_no_figure(compare, toolbox, tmp_path):
    """And no plotly.js."""
    pytest.importorskip("plotly")
    write_parity(compare(one=toolbox.ideal), tmp_path / "parity.html")
    page = (tmp_path / "parity.html").read_text(encoding="utf-8")
    assert "plotly" not in page
    assert page.count("<table>") == 1


def test_a_page_that_cannot_be_written_is_a_usage_error(found, tmp_path):
    """Named, with the reason."""
    pytest.importorskip("plotly")
    with pytest.raises(UsageError, match=r"no/parity\.html' cannot be written: No such file"):
        write_parity(found, tmp_path / "no" / "parity.html")


def test_without_plotly_the_extra_is_named(found, tmp_path, monkeypatch):
    """Nothing is written."""
    pytest.importorskip("jinja2")
    monkeypatch.setitem(sys.modules, "plotly.offline", None)
    with pytest.raises(UsageError, match=r"pip install 'fd100-harness\[report\]'"):
        write_parity(found, tmp_path / "parity.html")
    assert list(tmp_path.iterdir()) == []
