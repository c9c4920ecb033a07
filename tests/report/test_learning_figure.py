"""The figure of learning."""

import json

import pytest

from harness.eta.headline import SUCCESS
from harness.report.learning_figure import describe_learning, draw_learning
from harness.report.palette import BLUE, VERMILION
from harness.results.learning import learning_of


@pytest.fixture
def learning(build):
    """Baseline 25 %, 50 %, then 75 %; proposed one episode in four more, but at the end."""
    results = build(learned={10: 1, 20: 2})
    return learning_of(results, results.combinations[0])


def _named(figure):
    return {curve["name"]: curve for curve in figure["data"] if "name" in curve}


def test_curves_pass_through_the_means(learning):
    """In the report's colours."""
    curves = _named(draw_learning(learning, SUCCESS))
    assert (curves["baseline"]["x"], curves["baseline"]["y"]) == ([10, 20, 40], [0.25, 0.5, 0.75])
    assert (curves["arp"]["x"], curves["arp"]["y"]) == ([10, 20, 40], [0.5, 0.75, 0.75])
    assert [curves[name]["line"]["color"] for name in ("baseline", "arp")] == [BLUE, VERMILION]


def test_random_actions_are_a_dotted_line(learning):
    """Across the whole figure."""
    floor = _named(draw_learning(learning, SUCCESS))["random actions"]
    assert (floor["x"], floor["y"], floor["line"]["dash"]) == ([0, 40], [0.0, 0.0], "dot")


def test_bands_go_around_the_intervals(learning):
    """Along the upper ends and back along the lower ones; of one seed there is none."""
    bands = [curve for curve in draw_learning(learning, SUCCESS)["data"] if curve.get("fill") == "toself"]
    assert [band["x"] for band in bands] == [[10, 20, 40, 40, 20, 10]] * 2
    assert len(bands[0]["y"]) == 6


def test_one_seed_has_no_band(build):
    """There is no interval to draw."""
    results = build(seeds=1, learned={10: 1})
    figure = draw_learning(learning_of(results, results.combinations[0]), SUCCESS)
    assert [curve["x"] for curve in figure["data"] if curve.get("fill") == "toself"] == [[], []]


def test_figure_is_plain_data(learning):
    """Strict JSON."""
    figure = draw_learning(learning, SUCCESS)
    assert json.loads(json.dumps(figure, allow_nan=False)) == figure


def test_caption_says_where_the_curves_go(learning):
    """In words, for those who cannot see it."""
    assert describe_learning(learning, SUCCESS) == (
        "baseline 25.0% after 10 steps, 75.0% after 40 steps; "
        "arp 50.0% after 10 steps, 75.0% after 40 steps; random actions 0.0%."
    )
