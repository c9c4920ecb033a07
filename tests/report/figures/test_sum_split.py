"""The figure of a change that has no ratio."""

from harness.eta import Estimate
from harness.eta.splits import SumSplit
from harness.report import Dots, Line
from harness.report.figures.chart import Note
from harness.report.figures.split import describe_sum, draw_sum

SPLIT = SumSplit(Estimate(10.0, 8.0, 12.0), Estimate(7.0, 6.0, 8.0), Estimate(3.0, -1.0, 7.0))


def test_each_part_has_a_point_a_bar_and_its_number_beside_it():
    """In its own colour, the change first."""
    marks = draw_sum(SPLIT).marks
    dots = [it for it in marks if isinstance(it, Dots)]
    assert [(it.colour, *it.x) for it in dots] == [("ink", 10.0), ("ruler", 7.0), ("behaviour", 3.0)]
    assert [it.text for it in marks if isinstance(it, Note)] == [
        "10.0 [8.00, 12.0]",
        "7.00 [6.00, 8.00]",
        "3.00 [-1.00, 7.00]",
    ]
    assert [it.x for it in marks if isinstance(it, Line)][1:] == [[8.0, 12.0], [6.0, 8.0], [-1.0, 7.0]]


def test_one_seed_has_no_bar_nor_a_bracket():
    """But zero is in the picture, always: nothing changed there."""
    chart = draw_sum(SumSplit(Estimate(10.0), Estimate(7.0), Estimate(3.0)))
    assert [it.text for it in chart.marks if isinstance(it, Note)] == ["10.0", "7.00", "3.00"]
    assert sum(isinstance(it, Line) for it in chart.marks) == 1
    assert chart.x.low < 0.0
    assert chart.x.high > 10.0


def test_what_is_not_split_is_not_drawn():
    """There is nothing but the change, which the table has."""
    assert draw_sum(SumSplit(Estimate(10.0), Estimate(None), Estimate(None))) is None


def test_it_is_told_in_words():
    """For those who cannot see it."""
    assert describe_sum(SPLIT) == "Change 10.0 = ruler 7.00 + behaviour 3.00."
