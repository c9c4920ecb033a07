"""I_N and I_P as they are shown, and a ratio of two of them."""

import pytest

from harness.eta import Estimate, Index


def test_sums_are_shown_rounded_to_a_tenth():
    """I_N and I_P have one decimal, as published."""
    index = Index(0, 2, 4, -0.26, 0.44)
    assert (index.I_N, index.I_P) == (-0.3, 0.4)


def test_total_is_the_sum_of_the_whole_curve():
    """Of what both are before rounding: the first shows I_N = -0.4 and I_P = 0.3."""
    assert Index(0, 2, 4, -0.36, 0.34).total == 0.0
    assert Index(0, 2, 4, -0.26, 0.44).total == 0.2


@pytest.mark.parametrize("total", [-0.01, -0.0])
def test_sum_that_rounds_to_zero_has_no_sign(total):
    """Minus zero would be printed."""
    assert str(Index(0, None, 2, total, 0.0).I_N) == "0.0"


def test_index_as_json():
    """The keys of the table, the sums rounded, null where a step does not exist."""
    assert Index(1, None, 4, -3.14, 1.0).to_json() == {
        "first_negative": 1,
        "crossover": None,
        "steps": 4,
        "I_N": -3.1,
        "I_P": 1.0,
        "total": -2.1,
    }


@pytest.mark.parametrize(
    ("ratio", "told"),
    [
        (Estimate(2.0, 1.5, 2.5, 5, ("five seeds",)), (2.0, 1.5, 2.5, 5, "five seeds")),
        (Estimate(None, notes=("nothing to divide by",)), (None, None, None, 0, "nothing to divide by")),
    ],
)
def test_ratio_as_json(ratio, told):
    """A ratio is its value, the ends of its interval, the seeds and a note; it may be a reason alone."""
    assert ratio.to_json() == dict(zip(("value", "low", "high", "seeds", "note"), told, strict=True))


def test_index_near_zero_is_told_before_every_note():
    """In the note of the JSON; a reader of the ratio finds each by itself."""
    ratio = Estimate(2.0, 1.5, 2.5, 2, ("2 seeds",), near_zero="I_P of the baseline is near zero beside I_N")
    assert ratio.notes == ("2 seeds",)
    assert ratio.note == f"{ratio.near_zero}: the ratio says little; 2 seeds"
