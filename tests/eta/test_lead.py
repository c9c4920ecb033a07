"""The answer in a sentence: what it says, and that it never says more than the headline."""

import re

import numpy as np
import pytest
from hypothesis import given, strategies as st

from harness.eta import Answer, Ruling, Verdict, lead_of
from tests.eta.headlines import CLAIM, DECIDED, NAMES, PAIRS, TIME, change
from tests.eta.test_amounts import HEIGHT
from tests.results.told import SPEED

NOT_TESTED = Ruling()


def told(changes, ruling=NOT_TESTED, subject="robot", where="", same_steps=False):
    """The answer, and what is said of it."""
    found = Verdict(NAMES, changes, ruling, where, same_steps)
    return found.answer, lead_of(found, subject)


def ruled(*signs_and_p):
    """Each measure has its sign and its corrected p; a small one passes plainly."""
    signs, p_values = zip(*signs_and_p, strict=True)
    beyond = tuple(p <= 0.05 and sign != 0 for sign, p in signs_and_p)
    return Ruling(min(p_values), min(p_values), p_values, signs, beyond)


FAST = change([0.84, 0.86, 0.88], [0.36, 0.37, 0.38], TIME)
SAME = change([0.98, 0.99, 1.0], [1.0, 0.99, 0.98])
SOONER = change([0.3, 0.4, 0.5], [0.6, 0.7, 0.8], SPEED)
AROUND = list(0.9 + 0.01 * np.linspace(-1.0, 1.0, 80))
SECONDS = list(7.0 + 0.01 * np.linspace(-1.0, 1.0, 80))
PASSES, FAILS = (1, 0.01), (1, 0.9)
SAID = {
    "a decided answer says what the robot does instead, and of the other measure that nothing was found": (
        ([SAME, FAST], ruled(FAILS, PASSES)),
        Answer.HELPS,
        "The robot reaches its target in 0.37 s instead of 0.86 s. Whether success differs too cannot be told.",
    ),
    "learning more slowly": (([SAME, SOONER], ruled(FAILS, (-1, 0.01))), Answer.LEARNS_SLOWER, "learns more slowly: "),
    "a measure of an environment has its name and unit": (
        ([change([1.1, 1.2, 1.3], [1.9, 2.0, 2.1], HEIGHT)], ruled(PASSES), "agent"),
        Answer.HELPS,
        "Tip height is 2.00 m instead of 1.20 m.",
    ),
    "several places are told": (
        ([FAST], ruled(PASSES), "robot", "over 4 places"),
        Answer.HELPS,
        "The robot reaches its target in 0.37 s instead of 0.86 s, on average over 4 places.",
    ),
    "one": (([change([0.5], [0.6])],), Answer.CANNOT_TELL, "1 training of each reward is not enough to tell."),
    "a small difference has its margins": (
        ([change(AROUND, AROUND[::-1])], ruled(FAILS)),
        Answer.NO_DIFFERENCE,
        "The rewards differ by less than 5 points of success, also where trainings fail that were not seen.",
    ),
    "and that of the time": (
        ([change(SECONDS, SECONDS[::-1], TIME)], ruled(FAILS)),
        Answer.NO_DIFFERENCE,
        "The rewards differ by less than 10% of the time.",
    ),
}


@pytest.mark.parametrize("row", SAID)
def test_the_answer_is_said(row):
    """In whole sentences."""
    asked, answer, lead = SAID[row]
    found = told(*asked)
    assert found[0] == answer
    assert lead in found[1] if row == "learning more slowly" else lead == found[1]


@given(
    PAIRS,
    st.floats(0.0, 1.0),
    st.sampled_from([-1, 0, 1]),
)
def test_no_claim_without_a_test(values, p, sign):
    """No word of better or worse stands where the test does not say so, and no bracket anywhere.

    Where both fail at the task, a sentence says what the test says, and the answer is another one.
    """
    shown = change(*zip(*values, strict=True))
    answer, lead = told([shown], ruled((sign, p)))
    is_decided = p <= 0.05 and sign != 0
    fails = max(shown.baseline, shown.proposed) < 0.1
    assert (answer in DECIDED) == (is_decided and not fails)
    assert bool(CLAIM.search(lead)) == is_decided
    assert not re.search(r"[][()]", lead)
