"""The forest plot: what is right of the line is better."""

import re

import pytest

from harness.eta import Change, Quantity
from harness.report.figures.split import draw_part, draw_strip, draw_trainings

MIDDLE, REACH = 84.0, 74.0
"""Where no difference is, and how far from it the farthest end of a row, [px]."""


def change(better, low, high, corrected=None):
    """A difference in the middle of its interval."""
    middle = (low + high) / 2
    return Change(
        Quantity("m", "", better, "deterministic"), 0.0, middle, None, low=low, high=high, corrected=corrected
    )


def place(strip):
    """Of the dot, from the middle."""
    return float(re.search(r'cx="([\d.]+)"', strip)[1]) - MIDDLE


def test_better_is_to_the_right():
    """More where more is better, less where less is."""
    assert place(draw_strip(change("higher", 1.0, 3.0))) > 0.0
    assert place(draw_strip(change("lower", 1.0, 3.0))) < 0.0
    assert place(draw_strip(change("lower", -3.0, -1.0))) > 0.0


def test_row_has_a_scale_of_its_own():
    """Its farthest end is as far out in every row."""
    assert place(draw_strip(change("higher", 1.0, 3.0))) == pytest.approx(REACH * 2 / 3, abs=0.1)
    assert place(draw_strip(change("higher", 1e-6, 3e-6))) == pytest.approx(REACH * 2 / 3, abs=0.1)


def test_result_has_a_colour_only_where_a_test_says_so():
    """As the word in its row."""
    assert "better" in draw_strip(change("higher", 1.0, 3.0, 0.01))
    assert "worse" in draw_strip(change("lower", 1.0, 3.0, 0.01))
    assert "undecided" in draw_strip(change("higher", 1.0, 3.0, 0.2))


def test_no_difference_has_a_place():
    """In the middle."""
    assert place(draw_strip(change("higher", 0.0, 0.0))) == 0.0


def test_without_a_difference_there_is_nothing():
    """No seed has a value under both."""
    assert draw_strip(Change(Quantity("m", "", "higher", "deterministic"), None, None, None, 0)) == ""


@pytest.mark.parametrize(("size", "left", "width"), [(2.0, 0.0, REACH / 2), (-4.0, -REACH, REACH), (0.0, 0.0, 1.0)])
def test_a_part_is_a_bar_from_no_change(size, left, width):
    """To the right if it is above 0, as long as its share of the largest; a part that is 0 is still seen."""
    drawn = re.search(r'x="([\d.]+)" y="4" width="([\d.]+)"', draw_part(size, 4.0, "ruler"))
    assert float(drawn[1]) - MIDDLE == pytest.approx(left, abs=0.1)
    assert float(drawn[2]) == pytest.approx(width, abs=0.1)


def test_nothing_at_all_can_be_drawn_too():
    """Both parts are 0."""
    assert 'class="bar behaviour"' in draw_part(0.0, 0.0, "behaviour")


def test_trainings_have_what_is_better_on_the_right():
    """Also where less is; where all are the same they stand in the middle."""
    drawn = [draw_trainings([1.0, 3.0], (1.0, 3.0), better, "baseline") for better in ("higher", "lower")]
    places = [[float(at) - MIDDLE for at in re.findall(r'cx="([\d.]+)"', svg)] for svg in drawn]
    assert places == [[-REACH, REACH], [REACH, -REACH]]
    assert f'cx="{MIDDLE:.1f}"' in draw_trainings([2.0], (2.0, 2.0), "higher", "baseline")
