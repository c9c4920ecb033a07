import math

import numpy as np
import plotly.graph_objects as go

from harness.report.split_figure import draw_split
from harness.report.split_rows import describe_split


def figures(results):
    """The splits of the only combination, and their figures."""
    (combination,) = results.combinations
    both = combination.splits
    return both, {name: draw_split(name, split) for name, split in both.items()}


def test_every_part_is_drawn_with_its_interval(build):
    """A point per ratio, bars to both ends of its interval, on a logarithmic axis that holds them and 1."""
    both, drawn = figures(build())
    for name, figure in drawn.items():
        split = both[name]
        ratios = [split.eta, split.ruler, split.behaviour, *(part for path in split.paths for part in path)]
        assert [point["x"][0] for point in figure["data"]] == [ratio.value for ratio in ratios]
        bars = [(point["error_x"]["arrayminus"][0], point["error_x"]["array"][0]) for point in figure["data"]]
        expected = [(ratio.value - ratio.low, ratio.high - ratio.value) for ratio in ratios]
        np.testing.assert_allclose(bars, expected, atol=1e-12)
        low, high = figure["layout"]["xaxis"]["range"]
        assert figure["layout"]["xaxis"]["type"] == "log"
        assert low < min(0.0, *(math.log10(ratio.low) for ratio in ratios))
        assert high > max(0.0, *(math.log10(ratio.high) for ratio in ratios))
        assert figure["layout"]["shapes"][0]["x0"] == figure["layout"]["shapes"][0]["x1"] == 1


def test_near_zero_is_a_word_in_the_figure(build):
    """A ratio that says little is no point: it would stretch the axis."""
    _, drawn = figures(build(baseline=(9, 9), proposed={"arp": (1, 3_000)}, seeds=2))
    figure = drawn["eta_P"]
    assert [label["text"] for label in figure["layout"]["annotations"]] == ["near zero"] * 6
    assert len(figure["data"]) == 1
    assert figure["layout"]["xaxis"]["range"][1] < 1.0


def test_missing_part_is_a_word_in_the_figure(build):
    """What has no value is n/a in its row; what has one is still drawn."""
    _, drawn = figures(build(baseline=(39, 0)))
    assert [label["text"] for label in drawn["eta_P"]["layout"]["annotations"]] == ["n/a"] * 6
    assert [point["text"] for point in drawn["eta_P"]["data"]] == [["1.89"]]


def test_one_seed_has_points_without_bars(build):
    """Without an interval there is no bar."""
    _, drawn = figures(build(seeds=1))
    assert not any(point["error_x"]["visible"] for point in drawn["eta_N"]["data"])


def test_no_parts_no_figure(build):
    """What could not be split has no figure."""
    _, drawn = figures(build(proposed={"gone": (9, 30)}))
    assert set(drawn.values()) == {None}


def test_words_say_the_same(build):
    """The caption has every number of the figure."""
    both, drawn = figures(build())
    text = describe_split("eta_P", both["eta_P"])
    assert text == "eta_P 1.89 = ruler 1.89 x behaviour 1.00; interaction 1.00."
    assert all(point["text"][0] in text for point in drawn["eta_P"]["data"][:3])


def test_plotly_accepts_the_split(build):
    """Every property of the figures is one that plotly knows."""
    _, drawn = figures(build())
    assert [len(go.Figure(figure).data) for figure in drawn.values()] == [7, 7]
