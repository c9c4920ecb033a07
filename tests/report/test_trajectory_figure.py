"""The figure of the end effector's paths."""

import json

import numpy as np
import plotly.graph_objects as go
import pytest

from harness.report.trajectory_figure import POINTS, describe_trajectories, draw_trajectories
from harness.results.trajectories import Trajectories, Trajectory

HIT = Trajectory(np.array([[0.0, 1.0, 2.0], [0.123456, 1.5, 2.5]]), np.array([0.1, 1.5, 2.5]), reached=True)
MISS = Trajectory(np.array([[0.0, 0.0, 0.0], [5.0, -1.0, 3.0]]), np.array([-1.0, 0.0, 0.0]), reached=False)


@pytest.fixture
def figures():
    """One hit and two misses under the baseline, one hit under the proposed reward."""
    return draw_trajectories(Trajectories(0, (MISS, HIT, MISS), (HIT,)))


def named(figure):
    """The traces of a figure by name, one per projection."""
    found = {}
    for trace in figure["data"]:
        found.setdefault(trace["name"], []).append(trace)
    return found


def test_path_is_seen_from_above_and_from_the_side(figures):
    """Once x and y, once x and z, with four digits."""
    above, side = named(figures[1])["reached"]
    assert (above["x"], above["y"]) == ([0.0, 0.1235], [1.0, 1.5])
    assert (side["x"], side["y"]) == ([0.0, 0.1235], [2.0, 2.5])


def test_misses_are_told_apart_by_colour_and_shape(figures):
    """Another line, with a mark where each ends; without a miss there is neither."""
    traces = named(figures[0])
    hit, miss = traces["reached"][0]["line"], traces["missed"][0]["line"]
    assert hit["color"] != miss["color"]
    assert (hit.get("dash"), miss["dash"]) == (None, "dot")
    assert (traces["missed: its end"][0]["x"], traces["missed: its end"][0]["y"]) == ([5.0, 5.0], [-1.0, -1.0])
    assert set(named(figures[1])) == {"reached", "start", "target"}


def test_paths_do_not_touch_one_another(figures):
    """The line is broken between one episode and the next."""
    assert named(figures[0])["missed"][0]["x"] == [0.0, 5.0, None, 0.0, 5.0]


def test_every_start_and_target_is_marked(figures):
    """Of hits and misses."""
    traces = named(figures[0])
    assert [traces[name][0]["x"] for name in ("start", "target")] == [[0.0, 0.0, 0.0], [-1.0, 0.1, -1.0]]
    assert traces["start"][0]["marker"]["symbol"] != traces["target"][0]["marker"]["symbol"]


def test_axes_are_equal_and_hold_everything(figures):
    """The same under both rewards, targets among it, and a metre is a metre on all of them."""
    layouts = [figure["layout"] for figure in figures]
    assert layouts[0] == layouts[1]
    low, high = layouts[0]["xaxis"]["range"]
    assert low < -1.0 < 5.0 < high
    assert layouts[0]["xaxis"]["range"] == layouts[0]["xaxis2"]["range"]
    assert [layouts[0][name]["scaleanchor"] for name in ("yaxis", "yaxis2")] == ["x", "x2"]


def test_long_path_is_thinned():
    """A page has room for so many points; start and end stay."""
    walk = np.linspace([0.0, 0.0, 0.0], [1.0, 2.0, 3.0], 5_001)
    long = Trajectory(walk, walk[-1], reached=True)
    above, _ = named(draw_trajectories(Trajectories(0, (long,), (HIT,)))[0])["reached"]
    assert len(above["x"]) == POINTS
    assert (above["x"][0], above["x"][-1]) == (0.0, 1.0)


def test_arm_that_stands_still_has_axes():
    """A range without length would be none."""
    still = Trajectory(np.zeros((2, 3)), np.zeros(3), reached=True)
    low, high = draw_trajectories(Trajectories(0, (still,), (still,)))[0]["layout"]["xaxis"]["range"]
    assert low < 0.0 < high


def test_plotly_accepts_the_figures(figures):
    """They are strict JSON, and every property of them is one that plotly knows."""
    for figure in figures:
        assert json.loads(json.dumps(figure, allow_nan=False)) == figure
        assert len(go.Figure(figure).data) == len(figure["data"])


def test_caption_says_how_many_reach_the_target():
    """In words, for those who cannot see it."""
    told = describe_trajectories(3, (MISS, HIT, MISS))
    assert told == "Seed 3: 1 of the first 3 evaluation episodes reach the target."
