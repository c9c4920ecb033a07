"""The performance profile: a step line per reward."""

import numpy as np

from harness.eta.behaviour_change import Change, Quantity, change_of
from harness.eta.swaps import swaps_of
from harness.report.figures.profile import describe_profile, draw_profile

MEASURE = Quantity("success_rate", "", "higher", "deterministic", 100)


def change(baseline: list[float], proposed: list[float]) -> Change:
    """Of the success rate, by seed."""
    seeds = range(len(baseline))
    return change_of(
        MEASURE, dict(zip(seeds, baseline, strict=True)), dict(zip(seeds, proposed, strict=True)), swaps_of(seeds)
    )


def at(line, place):
    """Which share of the seeds reaches at least so much: before the line falls there."""
    return line.y[line.x.index(place)]


def test_lines_count_seeds():
    """At 50 % both seeds of the baseline are there and one of the proposed reward; at 100 % the other way round."""
    chart = draw_profile(change([0.5, 0.9], [0.2, 1.0]))
    assert chart is not None
    baseline, proposed = chart.marks
    assert [at(baseline, 0.5), at(baseline, 1.0)] == [1.0, 0.0]
    assert [at(proposed, 0.5), at(proposed, 1.0)] == [0.5, 0.5]


def test_a_share_that_is_reached_exactly_counts():
    """0.1 + 0.2 in floats is a little more than 0.3: who has 0.3 reaches 0.3."""
    chart = draw_profile(change([0.3], [np.nextafter(0.3, 0.0)]))
    assert chart is not None
    assert [at(line, 0.3) for line in chart.marks] == [1.0, 1.0]


def test_without_a_seed_there_is_none():
    """Nothing to draw."""
    assert draw_profile(Change(MEASURE, None, None, None)) is None


def test_caption_names_the_worst_seed():
    """Of either reward."""
    assert describe_profile(change([0.5, 0.9], [0.2, 1.0])) == (
        "2 seeds. The worst seed: 50% under the baseline, 20% under the proposed reward."
    )
