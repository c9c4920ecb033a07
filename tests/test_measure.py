"""What a metric says of itself."""

import math

import pytest

from harness.log.measure import bounds_of, is_error, is_share
from harness_plugins.kit.metrics import recorded_trace
from tests.plugins.metrics.test_every_metric import METRICS


def test_shares_say_that_they_are(subtests):
    """Means over episodes of something between 0 and 1; optimality may be above 1."""
    for name, share in [
        ("success_rate", True),
        ("ground_hits", True),
        ("timeouts", True),
        ("spl", True),
        ("optimality", False),
        ("time_to_target", False),
        ("work", False),
    ]:
        with subtests.test(name=name):
            assert is_share(METRICS[name]) == share


def test_those_of_the_distance_say_that_they_are_errors():
    """All metrics in whose values the column `distance` stands, and no other."""
    errors = {name for name, metric in METRICS.items() if is_error(metric)}
    assert errors == {"closest_distance", "final_distance"}


def test_a_metric_that_says_nothing_is_none():
    """Those of version 0.1 have no such attribute."""
    assert not is_error(object())  # type: ignore[arg-type]
    assert not is_share(object())  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", range(5))
def test_no_metric_leaves_its_bounds(seed):
    """On episodes of random numbers."""
    trace = recorded_trace(seed, ("ground", "reached", "truncated", "touched", "reached", ""))
    for name, metric in METRICS.items():
        value, (low, high) = metric(trace), bounds_of(metric)
        assert value is not None, name
        assert low <= value <= high, name


def test_shares_have_the_bounds_of_a_share():
    """Whatever else they say; a metric that says nothing has none."""
    assert bounds_of(METRICS["spl"]) == (0.0, 1.0)
    assert bounds_of(object()) == (-math.inf, math.inf)  # type: ignore[arg-type]
