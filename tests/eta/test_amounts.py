"""What was seen, in words: numbers that add up, intervals, trainings that failed."""

import pytest
from hypothesis import given, strategies as st

from harness.eta import Quantity
from harness.eta.amounts import difference_text, listed, short_values, unseen_text
from tests.eta.headlines import NAMES, SUCCESS, TIME, change

HEIGHT = Quantity("tip_height", "m", "higher", "deterministic")
COST = Quantity("energy", "J", "lower", "deterministic")


def test_values_have_as_many_digits_as_tell_them_apart(subtests):
    """Two; more where a reader would compute another difference from them."""
    for measure, (one, other), shown in [
        (SUCCESS, (0.81, 1.0), ("81", "100 %")),
        (SUCCESS, (0.99, 1.0), ("99.0", "100.0 %")),
        (SUCCESS, (0.75, 0.75), ("75", "75 %")),
        (SUCCESS, (0.45, 0.925), ("45.0", "92.5 %")),
        (SUCCESS, (0.5625, 0.6875), ("56.25", "68.75 %")),
        (TIME, (0.8613, 0.3591), ("0.86", "0.36 s")),
        (TIME, (0.8643, 0.3691), ("0.864", "0.369 s")),
        (TIME, (2.01, 1.9), ("2.01", "1.90 s")),
        (TIME, (9.96, 12.3), ("10.0", "12.3 s")),
        (HEIGHT, (1234.5, -0.0123), ("1,234.5", "-0.0 m")),
    ]:
        with subtests.test(shown):
            assert short_values(change([one] * 2, [other] * 2, measure)) == shown


@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_a_difference_is_that_of_the_values_beside_it(one, other):
    """As they are written, but for one in the last place."""
    shown = change([one] * 3, [other] * 3)
    baseline, proposed = (float(text.partition(" ")[0]) for text in short_values(shown))
    points = difference_text(shown, 2).partition(" ")[0]
    last = 10.0 ** -len(points.partition(".")[2])
    assert abs(proposed - baseline - float(points)) <= 1.001 * last


@pytest.mark.parametrize(("proposed", "measure"), [([0.0] + [1.0] * 9, SUCCESS), ([1.0] * 10, TIME)])
def test_failures_that_were_not_seen_are_told_where_none_was(proposed, measure):
    """Neither where one failed, nor where nothing says who fails."""
    assert unseen_text(NAMES, [change([1.0] * 10, proposed, measure)]) == ""


def test_lists_are_sentences():
    """With a word before the last."""
    assert listed(["a", "b", "c"], "or") == "a, b or c"
