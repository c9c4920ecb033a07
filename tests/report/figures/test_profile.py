"""The performance profile: a step line per reward."""

import numpy as np

from harness.report.figures.learning import describe_profile, draw_profile
from tests.results import told
from tests.results.told import SUCCESS


def change(baseline, proposed):
    """Of the success rate, by seed."""
    return told.change(SUCCESS, (baseline, proposed), range(len(baseline)))


def at(line, place):
    """Which share of the seeds reaches at least so much: before the line falls there."""
    return line.y[line.x.index(place)]


def test_lines_count_seeds():
    """At 50 % both seeds of the baseline are there and one of the proposed reward; at 100 % the other way round."""
    baseline, proposed = draw_profile(change([0.5, 0.9], [0.2, 1.0])).marks
    assert [at(baseline, 0.5), at(baseline, 1.0)] == [1.0, 0.0]
    assert [at(proposed, 0.5), at(proposed, 1.0)] == [0.5, 0.5]


def test_a_share_that_is_reached_exactly_counts():
    """0.1 + 0.2 in floats is a little more than 0.3: who has 0.3 reaches 0.3."""
    chart = draw_profile(change([0.3], [np.nextafter(0.3, 0.0)]))
    assert [at(line, 0.3) for line in chart.marks] == [1.0, 1.0]


def test_caption_names_the_worst_seed():
    """Of either reward."""
    assert describe_profile(change([0.5, 0.9], [0.2, 1.0])) == (
        "2 seeds. The worst seed: 50% under the baseline, 20% under the proposed reward."
    )
