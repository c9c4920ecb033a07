"""What an experiment took."""

from dataclasses import replace

import pytest

from harness_plugins.committed.markdown import duration_text, effort_of


def test_seconds_are_added_and_the_span_is_from_first_to_last(build):
    """Cells that run beside one another take less together; what never ran counts as nothing."""
    first, second, third, *_ = build(seeds=2, ended={("baseline", 1): ("pending", "")}).manifests
    later = replace(second, started="2026-01-01T00:00:10+00:00", seconds=100.0)
    effort = effort_of([later, first, third])
    assert (effort.cells, effort.seconds, effort.span) == (2, 112.5, 110.0)


def test_nothing_ran_no_span():
    """There is no time to tell."""
    effort = effort_of([])
    assert (effort.cells, effort.seconds, effort.span) == (0, 0, None)


@pytest.mark.parametrize(
    ("seconds", "text"), [(12.54, "12.5 s"), (99.9, "99.9 s"), (1_500.0, "25 min"), (11_100.0, "3 h 5 min")]
)
def test_durations_are_for_people(seconds, text):
    """Seconds, minutes or hours."""
    assert duration_text(seconds) == text
