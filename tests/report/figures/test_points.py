"""Which points of a curve are drawn."""

import numpy as np
import pytest
from numpy.random import default_rng

from harness.report.figures.accumulated import points_of_a_run, select_points


@pytest.mark.parametrize("count", [1_001, 54_920])
def test_drawn_points_keep_the_extremes(count):
    """The highest, the lowest, the first and the last step of a run are drawn, in order, in at most 240 points."""
    values = default_rng(0).normal(size=count)
    steps = select_points(values)
    assert len(steps) <= 240
    assert {0, count - 1, values.argmin(), values.argmax()} <= set(steps.tolist())
    assert (np.diff(steps) > 0).all()


def test_short_run_is_drawn_whole():
    """Nothing is left out of a run that has no more steps than are drawn."""
    assert select_points(np.ones(240)).tolist() == list(range(240))


@pytest.mark.parametrize(("runs", "points"), [(0, 240), (20, 240), (1_000, 80), (10**6, 40)])
def test_page_of_many_runs_has_fewer_points_of_each(runs, points):
    """All together they are no more than a page can hold, while a run's shape can be seen."""
    assert points_of_a_run(runs) == points
    assert points == 40 or runs * points <= 80_000
