"""Durations in words."""

import pytest

from harness.cli.progress import about, left_text


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.2, "1 s"),
        (9.4, "9 s"),
        (12.0, "10 s"),
        (41.0, "40 s"),
        (97.0, "95 s"),
        (98.0, "2 min"),
        (185.0, "3 min"),
        (5_800.0, "97 min"),
        (7_900.0, "2 h 10 min"),
        (7_200.0, "2 h"),
        (35_200.0, "9 h 50 min"),
        (50_000.0, "14 h"),
    ],
)
def test_a_duration_is_rounded_to_what_can_be_known(seconds, text):
    """To 5 seconds, to minutes, to 10 minutes, to hours."""
    assert about(seconds) == f"about {text}"


def test_what_may_end_sooner_is_at_most():
    """Of a run in looks."""
    assert left_text(185.0) == "about 3 min left"
    assert left_text(185.0, at_most=True) == "at most 3 min left"
