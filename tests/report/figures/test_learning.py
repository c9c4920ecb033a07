"""The figure of learning."""

import pytest

from harness.report import Line, describe_learning, draw_learning, format_number
from harness.report.figures.chart import Area


@pytest.fixture
def learning(build):
    """Baseline 25 %, 50 %, then 75 %; proposed one episode in four more, but at the end."""
    results = build(learned={10: 1, 20: 2})
    return results.learning(results.combinations[0])


def _named(chart):
    return {mark.name: mark for mark in chart.marks if isinstance(mark, Line)}


def _bands(chart):
    return [mark for mark in chart.marks if isinstance(mark, Area)]


def test_curves_pass_through_the_means(learning):
    """In the report's colours; shares as percentages."""
    chart = draw_learning(learning, "success_rate")
    assert [text for _, text in chart.y.ticks] == ["0%", "25%", "50%", "75%", "100%"]
    curves = _named(chart)
    assert (curves["baseline"].x, curves["baseline"].y) == ([10, 20, 40], [0.25, 0.5, 0.75])
    assert (curves["arp"].x, curves["arp"].y) == ([10, 20, 40], [0.5, 0.75, 0.75])
    assert [curves[name].colour for name in ("baseline", "arp")] == ["baseline", "proposed"]


def test_random_actions_are_a_dotted_line(learning):
    """Across the whole figure."""
    floor = _named(draw_learning(learning, "success_rate"))["random actions"]
    assert (floor.x, floor.y, floor.dash) == ([0, 40], [0.0, 0.0], "2 4")


def test_bands_go_around_the_intervals(learning):
    """Along the upper ends and back along the lower ones; of one seed there is none."""
    bands = _bands(draw_learning(learning, "success_rate"))
    assert [band.x for band in bands] == [[10, 20, 40, 40, 20, 10]] * 2
    assert len(bands[0].y) == 6


def test_caption_says_where_the_curves_go(learning):
    """In words, for those who cannot see it."""
    assert describe_learning(learning, "success_rate") == (
        "baseline 25.0% after 10 steps, 75.0% after 40 steps; "
        "arp 50.0% after 10 steps, 75.0% after 40 steps; random actions 0.0%. "
        "Each point is of an evaluation of 4 episodes."
    )


def test_what_is_no_share_has_an_axis_of_numbers(learning):
    """From the lowest to the highest value; words and dots tell numbers too."""
    chart = draw_learning(learning, "success_rate", format_number)
    assert chart.y.low < min(value for band in _bands(chart) for value in band.y) < chart.y.high < 2.0
    assert not [text for _, text in chart.y.ticks if "%" in text]
    assert "baseline 0.250 after 10 steps" in describe_learning(learning, "success_rate", format_number)
