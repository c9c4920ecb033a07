import numpy as np
import plotly.graph_objects as go
import pytest

from harness.eta.scored_sums import BB, KK
from harness.report.figure import draw_panels
from harness.report.regions import OMEGA_1, OMEGA_2


def panels(results):
    """The only combination and its two panels."""
    (combination,) = results.combinations
    return combination, draw_panels(combination)


def curves(panel):
    """The lines of a panel, the markers left out."""
    return [trace for trace in panel["data"] if trace["mode"] == "lines"]


def labels(panel):
    """What is written into a panel."""
    return [label["text"] for label in panel["layout"]["annotations"]]


def test_every_run_is_thin_and_their_mean_thick(build):
    """A panel holds one thin curve per seed and the mean curve, thicker and last."""
    combination, drawn = panels(build(seeds=3))
    for panel, pair in zip(drawn, (BB, KK), strict=True):
        runs = combination.curves[pair].runs
        *thin, thick = curves(panel)
        assert [trace["name"] for trace in thin] == ["seed 0", "seed 1", "seed 2"]
        np.testing.assert_allclose([trace["y"] for trace in thin], runs, rtol=1e-5)
        np.testing.assert_allclose(thick["y"], runs.mean(axis=0), rtol=1e-5, atol=1e-6)
        assert thick["line"]["width"] > 2 * thin[0]["line"]["width"]


def test_long_run_is_drawn_at_its_steps(build):
    """Of a long run every so many steps are kept; they, and the marks between them, are drawn where they belong."""
    combination, (panel, _) = panels(build(seeds=1, baseline=(7_001, 12_998)))
    curve = combination.curves[BB]
    assert curve.stride > 1
    (drawn, _), dots = curves(panel), panel["data"][-1]
    assert drawn["x"][-1] == (curve.runs.shape[1] - 1) * curve.stride
    assert drawn["y"][drawn["x"].index(drawn["x"][-1])] == pytest.approx(12_998 - 7_001, abs=curve.stride)
    assert dots["x"] == [1, 14_002]
    np.testing.assert_allclose(dots["y"], [-1.0, 0.0], atol=1e-6)


def test_first_negative_and_crossover_are_marked(build):
    """Both steps have a dot on the mean curve, a line and a label with the step."""
    _, (panel, other) = panels(build())
    assert other["data"][-1]["x"] == [1, 15]  # k2 lets it climb faster
    dots = panel["data"][-1]
    assert dots["x"] == [1, 18]
    assert [line["x0"] for line in panel["layout"]["shapes"]] == [1, 18]
    assert labels(panel)[:2] == ["first negative: step 1", "cross-over: step 18"]


def test_what_never_happens_is_not_marked(build):
    """A curve that is never negative has no mark."""
    _, (_, panel) = panels(build(proposed={"arp": (0, 39)}))
    assert panel["layout"]["shapes"] == panel["data"][-1]["x"] == []
    assert labels(panel) == [OMEGA_2]


def test_regions_of_the_indices_are_shaded(build):
    """Below 0 up to the cross-over, above 0 behind it, each with its name inside, under all curves."""
    _, (panel, _) = panels(build())
    below, above = panel["data"][:2]
    assert (below["name"], above["name"]) == (OMEGA_1, OMEGA_2)
    assert [shade["fill"] for shade in panel["data"] if "fill" in shade] == ["tozeroy", "tozeroy"]
    assert max(below["y"]) == min(above["y"]) == 0.0
    assert below["x"][-1] <= 18 <= above["x"][1]
    for shade, label in zip((below, above), panel["layout"]["annotations"][2:], strict=True):
        assert shade["x"][0] < label["x"] < shade["x"][-1]
        assert min(shade["y"]) < label["y"] < max(shade["y"])


def test_panels_have_equal_axes(build):
    """Both panels span the same steps and rewards, all values and zero among them, and zooming keeps the rewards so."""
    _, drawn = panels(build(proposed={"arp": (0, 59)}))
    layouts = [panel["layout"] for panel in drawn]
    assert layouts[0]["xaxis"]["range"] == layouts[1]["xaxis"]["range"] == [0, 59]
    low, high = layouts[0]["yaxis"]["range"]
    assert [low, high] == layouts[1]["yaxis"]["range"]
    assert low < -9.0
    assert high > 1.5 * 1.2 * 59
    assert all(layout["yaxis"]["fixedrange"] for layout in layouts)


def test_colours_differ_between_the_rewards(build):
    """The two panels are told apart by colour too."""
    _, drawn = panels(build())
    assert len({trace["line"]["color"] for panel in drawn for trace in curves(panel)}) == 2


def test_plotly_accepts_the_figures(build):
    """Every property of a figure is one that plotly knows."""
    _, drawn = panels(build())
    for panel in drawn:
        assert len(go.Figure(panel).data) == len(panel["data"])


def test_no_pair_no_figure(build):
    """Without a finished pair there is nothing to draw."""
    _, drawn = panels(build(seeds=1, ended={("arp", 0): ("failed", "it broke")}))
    assert drawn is None
