"""The page: figures of every pair, tables, and nothing from elsewhere."""

import re

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harness_plugins.parity import write_parity
from harness_plugins.parity.page import JOINTS, TIPS, draw_all_pairs, draw_pairs


@pytest.fixture(scope="module")
def found(compare, toolbox):
    """One that is right, one a millimetre off, one that is late."""
    return compare(right=toolbox.ideal, off=toolbox.shifted_tip(1e-3), late=toolbox.late)


def test_a_line_for_each_pair(found):
    """Those against the reference first, all of them in the second figure; no two look the same."""
    first, second = draw_pairs(found, TIPS).marks, draw_all_pairs(found, TIPS).marks
    assert [line.name for line in first] == ["off against right", "late against right"]
    assert [line.name for line in second] == ["off against right", "late against right", "late against off"]
    assert len({(line.colour, line.dash) for line in second}) == 3


def test_lines_are_in_millimetres_degrees_and_seconds(found):
    """The first pair's tips are 1 mm apart from the first moment to the last."""
    tips, joints = (draw_pairs(found, curve) for curve in (TIPS, JOINTS))
    assert_allclose(tips.marks[0].y, 1.0)
    assert_allclose(tips.marks[0].x, np.arange(41) * 0.1)
    assert max(joints.marks[1].y) == pytest.approx(np.degrees(found.pairs[1].drift.max_joint_error_rad), rel=1e-5)
    assert "[mm]" in tips.y.title
    assert "[deg]" in joints.y.title


def test_no_difference_has_no_place_on_a_logarithmic_axis(found):
    """The joints of the arm whose tip is off are where they should be: of its line nothing is drawn."""
    chart = draw_all_pairs(found, JOINTS)
    assert chart.y.is_log
    assert np.isnan(chart.marks[0].y).all()
    assert np.nanmax(chart.marks[1].y) <= chart.y.high


def test_without_the_reference_every_line_is_shown(compare, toolbox):
    """There is nothing else to show."""
    assert len(draw_pairs(compare(bad=toolbox.closed, one=toolbox.ideal, two=toolbox.late), TIPS).marks) == 1


def test_the_page_is_whole_and_loads_nothing(found, tmp_path):
    """Two figures and two folded ones, the tables, three of them by class, and a policy that forbids the rest."""
    write_parity(found, tmp_path / "parity.html")
    page = (tmp_path / "parity.html").read_text()
    assert "default-src 'none'; style-src 'unsafe-inline'" in page
    assert not re.search(r"<(link|img|iframe|object|embed|script|a) ", page)
    assert page.count('role="img"') == 4
    assert page.count("<table>") == 6
    assert "late against off" in page


def test_names_cannot_inject(compare, toolbox, tmp_path):
    """What a simulator calls itself is text."""
    write_parity(compare(**{"<script>alert(1)</script>": toolbox.ideal, "b": toolbox.ideal}), tmp_path / "parity.html")
    assert "<script>alert" not in (tmp_path / "parity.html").read_text()


def test_without_pairs_there_is_no_figure(compare, toolbox, tmp_path):
    """But the table."""
    write_parity(compare(one=toolbox.ideal), tmp_path / "parity.html")
    page = (tmp_path / "parity.html").read_text()
    assert "<svg" not in page
    assert page.count("<table>") == 1
