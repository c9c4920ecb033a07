from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

from harness.eta import Curve, Curves, Span, counted, latest_shared, require_share, shortfall_beside, within
from tests.refusals import refused

A, B = Path("runs/a"), Path("runs/b")


@given(st.sets(st.integers(0, 1000), min_size=3, max_size=30), st.floats(0, 40), st.integers(0, 100))
def test_a_mean_over_steps_does_not_depend_on_the_points_that_tell_it(points, window, begin):
    """One line logged anywhere, of values that average any window: the mean is that of the line."""
    at = np.array(sorted({*points, 0, 1000}), float)
    curve, over = Curve(at + window / 2, at - window / 2), Span(begin, 900)
    assert curve.mean(0.001 * at, over) == pytest.approx(0.0005 * (begin + 900))


def test_a_span_in_which_too_little_stands_is_not_known():
    """Half of it has to be; and no curve is asked where another one has fewer points."""
    assert within(Span(80, 100), Span(0, 90)) == Span(80, 90)
    assert within(Span(80, 100), Span(0, 89)) is None
    sparse, dense = (np.linspace(0, 100, count) for count in (3, 101))
    both = Curves((Curve(sparse, sparse), Curve(dense + 10, dense + 10)))
    assert (both.known, both.fewest(Span(80, 100))) == (Span(10, 100), 1)
    assert both.curves[0].mean(np.array([0.0, np.nan, 1.0]), both.known) is None


@pytest.mark.parametrize(
    ("times", "begin", "places"),
    [
        ([[10, 20, 30], [10, 20, 31]], 0, [1, 1]),
        ([[9_999, 19_998], [10_000, 20_000]], 16_000, [1, 1]),
        ([[10, 20, 30], [10, 20, 31]], 24, None),
        ([[10, 20], [11, 21]], 0, None),
    ],
)
def test_policies_are_compared_after_as_many_steps(times, begin, places):
    """The latest moment that all share; a hundredth of the steps is another moment."""
    assert latest_shared(times, begin) == places


def test_whatever_was_begun_is_whole_or_missing_or_left_out_by_name():
    """The lines say what to type, and a path at which nothing lies is refused."""
    begun = [("a", A / "1", ""), ("b", B / "1", "it broke off"), (None, B / "it's", "it is no log")]
    found = counted(begun)
    assert counted([(None, B, f"{B} is empty")]).lines[0] == "'runs/b' is missing: it is empty"
    assert (found.whole, [it.path for it in found.missing]) == (("a",), [B / "1", B / "it's"])
    assert found.lines[-1].endswith("--leave-out 'runs/b/1' --leave-out 'runs/b/it'\\''s' leaves it out")
    assert counted(begun, [B]).lines == (
        "'runs/b/1' is left out, as --leave-out says: it broke off",
        "'runs/b/it's' is left out, as --leave-out says: it is no log",
    )
    with refused("--leave-out runs/c: no training lies there, but at runs/a/1, runs/b/1"):
        counted(begun, [Path("runs/c")])


def test_who_stopped_before_others_of_its_reward_is_short():
    """By steps and by rows, as a plan may be of either; another reward may have another plan."""
    done = {"a1": (100, 40), "a2": (96, 12), "a3": (60, 12), "a4": (60, 39), "b1": (60, 12)}
    assert shortfall_beside({it: (it[0], *of) for it, of in done.items()}, "steps") == {
        "a3": "it ends after 60 steps, and another one of a after 100"
    }


def test_a_share_beyond_one_is_refused_for_all():
    """The message counts them."""
    require_share("success", {"a": np.array([0.0, np.nan, 1.0])}, str)
    with refused("is 40 in b, one of 1 of 2 trainings"):
        require_share("success", {"a": np.array([0.5]), "b": np.array([0.0, 40.0])}, str)
