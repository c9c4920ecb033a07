"""Other weights of recorded terms."""

import numpy as np
import pytest

from harness.registry import Choice
from harness.score.weights import label_by_terms, recorded_choice, reweighted
from tests.refusals import refused

TERMS = {"reach": np.array([0.0, -1.0, -0.5]), "effort": np.array([0.0, -0.2, 0.3])}
PLAIN = Choice("gentle", (("reach", 1.0), ("effort", 1.0)), "gentle")


def test_a_weight_multiplies_its_term():
    """And the pay is the sum of the terms in their order."""
    paid = reweighted("gentle:effort=0.05", PLAIN, TERMS)
    np.testing.assert_array_equal(paid.terms["reach"], TERMS["reach"])
    np.testing.assert_array_equal(paid.terms["effort"], TERMS["effort"] * 0.05)
    np.testing.assert_array_equal(paid.total, paid.terms["reach"] + paid.terms["effort"])


def test_weights_are_those_of_the_function_and_not_of_what_was_recorded():
    """A column that was recorded with the weight 5 is divided by it."""
    heavy = Choice("gentle", (("reach", 1.0), ("effort", 5.0)), "gentle:effort=5")
    recorded = {**TERMS, "effort": 5.0 * TERMS["effort"]}
    np.testing.assert_allclose(reweighted("gentle", heavy, recorded).terms["effort"], TERMS["effort"], rtol=1e-15)
    both = reweighted("gentle:effort=2,reach=3", heavy, recorded)
    np.testing.assert_allclose(both.total, 3.0 * TERMS["reach"] + 2.0 * TERMS["effort"], rtol=1e-14)


def test_the_recorded_weights_give_the_recorded_pay_to_the_last_bit():
    """Nothing is multiplied."""
    heavy = Choice("gentle", (("reach", 1.0), ("effort", 0.1)), "gentle:effort=0.1")
    assert reweighted("gentle:effort=0.1", heavy, TERMS).terms["effort"] is TERMS["effort"]


def test_a_recorded_weight_of_0_cannot_be_undone():
    """The column holds nothing; says what to do."""
    off = Choice("gentle", (("reach", 1.0), ("effort", 0.0)), "gentle:effort=0")
    with refused(r"'effort' was recorded with the weight 0.*--plugin FILE"):
        reweighted("gentle", off, {**TERMS, "effort": np.zeros(3)})
    assert reweighted("gentle:effort=0,reach=2", off, TERMS).terms["reach"][1] == -2.0


def test_an_unknown_term_is_told_with_the_nearest():
    """And all there are."""
    with refused(r"Reward 'gentle' has no term 'efort' to weigh.*reach, effort.*mean 'effort'"):
        reweighted("gentle:efort=2", PLAIN, TERMS)


@pytest.mark.parametrize("weight", ["heavy", "nan", "1e19", "inf"])
def test_a_weight_is_a_number(weight):
    """Not too large to count with."""
    with refused(f"effort={weight} is no weight: give a number from -1e.18 to 1e.18"):
        reweighted(f"gentle:effort={weight}", PLAIN, TERMS)


@pytest.mark.parametrize(
    "choice",
    [
        Choice("arp", (("k1", 1.0),), "arp"),
        Choice("odd", (("effort", 2.0),), "odd"),
        Choice("odd", (("effort", 1.0),), "odd:effort=1"),
        recorded_choice("odd:k=3"),
    ],
)
def test_parameters_that_are_no_weights_are_not_taken_for_some(choice):
    """Whose default is not 1, or which have no term of their name: only the code can tell."""
    with refused("are not the weights of its terms"):
        reweighted(f"{choice.name}:effort=7", choice, TERMS)
    np.testing.assert_array_equal(reweighted(choice.label, choice, TERMS).total, sum(TERMS.values()))


def test_a_label_is_that_of_a_run_with_these_weights():
    """In the terms' order, without weights of 1."""
    terms = ("reach", "effort", "jerk")
    recorded = [("other", ("jerk",)), ("gentle:jerk=7", terms)]
    assert label_by_terms("gentle:jerk=2,reach=1,effort=0.050", recorded) == "gentle:effort=0.05,jerk=2"
    assert label_by_terms("gentle:effort=1", recorded) == "gentle"
