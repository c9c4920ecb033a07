"""The figure of the end effector's paths."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from harness.report import Line
from harness.report.figures.learning import describe_trajectories, draw_trajectories
from harness.results.replay import Trajectories, Trajectory

HIT = Trajectory(np.array([[0.0, 1.0, 2.0], [0.123456, 1.5, 2.5]]), np.array([0.1, 1.5, 2.5]), reached=True)
MISS = Trajectory(np.array([[0.0, 0.0, 0.0], [5.0, -1.0, 3.0]]), np.array([-1.0, 0.0, 0.0]), reached=False)


@pytest.fixture
def figures():
    """One hit and two misses under the baseline, one hit under the proposed reward."""
    return draw_trajectories(Trajectories(0, (MISS, HIT, MISS), (HIT,)))


def named(charts):
    """The marks of one reward's charts by name, one per projection."""
    found = {}
    for chart in charts:
        for mark in chart.marks:
            found.setdefault(mark.name if isinstance(mark, Line) else mark.legend, []).append(mark)
    return found


def test_paths_are_seen_from_above_and_from_the_side(figures):
    """Once x and y, once x and z; the line is broken between one episode and the next."""
    above, side = named(figures[1])["reached"]
    assert (above.x[:2], above.y[:2]) == ([0.0, 0.123456], [1.0, 1.5])
    assert (side.x[:2], side.y[:2]) == ([0.0, 0.123456], [2.0, 2.5])
    assert_array_equal(named(figures[0])["missed"][0].x, [0.0, 5.0, np.nan, 0.0, 5.0, np.nan])


def test_misses_are_told_apart_by_colour_and_shape(figures):
    """Another line, with a mark where each ends; every start and target is marked, of hits and misses."""
    marks = {name: of[0] for name, of in named(figures[0]).items()}
    hit, miss = marks["reached"], marks["missed"]
    assert hit.colour != miss.colour
    assert (bool(hit.dash), bool(miss.dash)) == (False, True)
    assert (marks["missed: its end"].x, marks["missed: its end"].y) == ([5.0, 5.0], [-1.0, -1.0])
    assert [marks[name].x for name in ("start", "target")] == [[0.0, 0.0, 0.0], [-1.0, 0.1, -1.0]]
    assert marks["start"].shape != marks["target"].shape
    assert set(named(figures[1])) == {"reached", "start", "target"}


def test_axes_are_equal_and_hold_everything(figures):
    """The same under both rewards, targets among it, and a metre is a metre on all of them."""
    axes = [[(chart.x, chart.y) for chart in charts] for charts in figures]
    assert axes[0] == axes[1]
    lengths = [axis.high - axis.low for pair in axes[0] for axis in pair]
    assert_allclose(lengths, lengths[0])
    assert axes[0][0][0].low < -1.0 < 5.0 < axes[0][0][0].high
    assert all(chart.is_square for charts in figures for chart in charts)


def test_long_path_is_thinned():
    """A page has room for so many points; start and end stay."""
    walk = np.linspace([0.0, 0.0, 0.0], [1.0, 2.0, 3.0], 5_001)
    long = Trajectory(walk, walk[-1], reached=True)
    above, _ = named(draw_trajectories(Trajectories(0, (long,), (HIT,)))[0])["reached"]
    assert len(above.x) == 30 + 1  # the gap behind it
    assert (above.x[0], above.x[-2]) == (0.0, 1.0)


def test_arm_that_stands_still_has_axes():
    """A range without length would be none."""
    still = Trajectory(np.zeros((2, 3)), np.zeros(3), reached=True)
    chart, _ = draw_trajectories(Trajectories(0, (still,), (still,)))[0]
    assert chart.x.low < 0.0 < chart.x.high


def test_caption_says_how_many_reach_the_target():
    """In words, for those who cannot see it."""
    told = describe_trajectories(3, (MISS, HIT, MISS))
    assert told == "Seed 3: 1 of the first 3 evaluation episodes reach the target."
