"""Terms: what a reward returned, and that a total is their sum."""

from functools import reduce
from operator import add

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.testing import assert_array_equal

from harness.reward.terms import paid_of, require_same
from tests.refusals import refused

ONE, TWO = np.array([1.0, 2.0]), np.array([0.5, 0.25])


@pytest.mark.parametrize(
    "returned",
    [
        {"a": ONE, "b": TWO},
        (ONE + TWO, {"a": ONE, "b": TWO}),
        {"a": ONE, "b": TWO, "total": ONE + TWO},
        (np.float32(ONE + TWO), {"a": ONE, "b": TWO}),
    ],
)
def test_terms_are_given_in_four_ways(returned):
    """A dict, (total, dict) as Eureka writes it, a dict with its total; in single precision too."""
    paid = paid_of(returned)
    assert list(paid.terms) == ["a", "b"]
    assert_array_equal(paid.total, ONE + TWO)


@given(st.lists(st.floats(-1e9, 1e9), min_size=1, max_size=8))
def test_the_pay_is_the_sum_in_the_order_of_the_terms(values):
    """To the last bit."""
    paid = paid_of({f"t{number}": np.array([value]) for number, value in enumerate(values)})
    assert paid.total[0] == reduce(add, values)
    assert paid.total[0] == reduce(add, [term[0] for term in paid.terms.values()])


def test_a_plain_value_has_no_terms():
    """An array or a number."""
    assert paid_of(ONE) == (ONE, {})
    assert paid_of(3.0).terms == {}


def test_a_number_among_arrays_is_that_of_every_env():
    """As in `{"alive": 1.0}`."""
    assert_array_equal(paid_of({"reach": ONE, "alive": 1.0}).terms["alive"], [1.0, 1.0])


def test_masks_are_added_as_numbers():
    """Numpy adds two masks to a mask."""
    mask = np.array([True, False])
    assert_array_equal(paid_of({"a": mask, "b": mask}).total, [2.0, 0.0])


@pytest.mark.parametrize("kind", [float, np.float32, lambda value: np.full(2, value, np.float32)])
def test_a_total_of_terms_that_cancel_out_may_be_added_in_another_order(kind):
    """In single precision the error is that of the largest term."""
    near, far, back = np.float32(0.1), np.float32(1000.0), np.float32(-1000.0)
    terms = {"near": kind(near), "far": kind(far), "back": kind(back)}
    assert abs((near + far + back) - (far + back + near)) > 1e-5
    paid_of((kind(far + back + near), terms))
    with refused("is not the sum"):
        paid_of((kind(np.float32(0.105)), terms))


def test_a_single_term_called_total_is_a_term():
    """There is nothing that it could be the sum of."""
    assert list(paid_of({"total": ONE}).terms) == ["total"]


def test_what_are_no_terms_is_refused(subtests):
    """With what to return instead."""
    for returned, told in [
        ((ONE, {"a": ONE, "b": TWO}), r"The total 1 is not the sum of its terms, 1\.5 \(a 1, b 0\.5\)"),
        ({"a": ONE, "b": TWO, "total": ONE}, "is not the sum of its terms"),
        ((ONE * np.nan, {"a": ONE}), "is not the sum of its terms"),
        ({}, "A dict of terms is empty"),
        ({"a/b": ONE}, "'a/b' is no name of a term"),
        ({"": ONE}, "'' is no name of a term"),
        ({3: ONE}, "3 is no name of a term"),
        ({"x" * 61: ONE}, "at most 60"),
    ]:
        with subtests.test(returned=returned), refused(told):
            paid_of(returned)


def test_other_terms_than_at_first_are_refused():
    """A column of each is recorded from the first step on."""
    require_same(("a", "b"), {"b": ONE, "a": TWO})
    with refused("the terms a, b at first, and now a: return every term in every step"):
        require_same(("a", "b"), {"a": ONE})
