"""The answer in a sentence: what it says, and that it never says more than the headline."""

import re

import numpy as np
import pytest
from hypothesis import given, strategies as st

from harness.eta import Answer, Quantity, Ruling, Verdict, lead_of
from tests.eta.headlines import CLAIM, DECIDED, NAMES, PAIRS, SPEED, TIME, change

HEIGHT = Quantity("tip_height", "m", "higher", "deterministic")


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
MORE = change([0.5, 0.6, 0.7], [0.9, 0.91, 0.92])
OPEN = change([0.5, 0.6, 0.7], [0.55, 0.7, 0.6])
LESS = change([0.9] * 3, [0.5] * 3)
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
    "a second measure that is better has a sentence of its own": (
        ([MORE, FAST], ruled(PASSES, PASSES)),
        Answer.HELPS,
        "The robot succeeds in 91 % instead of 60 % of its episodes. The robot also reaches its target in 0.37 s "
        "instead of 0.86 s.",
    ),
    "what is worse stands beside what is better, that of the measure that says most first": (
        ([LESS, FAST], ruled((-1, 0.02), PASSES)),
        Answer.MIXED,
        "Worse: success, 50 % instead of 90 %. Better: time to the target, 0.37 s instead of 0.86 s.",
    ),
    "learning faster says that the end is open": (
        ([SAME, SOONER], ruled(FAILS, PASSES)),
        Answer.LEARNS_FASTER,
        "The robot learns faster: 70 % instead of 40 % of its episodes succeed while training. Whether the end "
        "differs too cannot be told.",
    ),
    "learning more slowly": (([SAME, SOONER], ruled(FAILS, (-1, 0.01))), Answer.LEARNS_SLOWER, "learns more slowly: "),
    "a difference of the deciding measure below its margin is little": (
        ([SAME, change([2.0, 2.01, 2.02], [1.89, 1.9, 1.91], TIME)], ruled(FAILS, PASSES)),
        Answer.HELPS,
        "The robot reaches its target in 1.90 s instead of 2.01 s. That is little: less than 10% of the time.",
    ),
    "a measure of an environment has its name and unit": (
        ([change([1.1, 1.2, 1.3], [1.9, 2.0, 2.1], HEIGHT)], ruled(PASSES), "agent"),
        Answer.HELPS,
        "Tip height is 2.00 m instead of 1.20 m.",
    ),
    "these trainings alone": (
        ([MORE, SOONER], Ruling(0.01, 0.01, (0.01, 0.02), (1, 1), (False, False))),
        Answer.AHEAD,
        "In these trainings: the robot succeeds in 91 % instead of 60 % of its episodes. 70 % instead of 40 % of its "
        "episodes succeed while training. New ones may not differ.",
    ),
    "several places are told": (
        ([FAST], ruled(PASSES), "robot", "over 4 places"),
        Answer.HELPS,
        "The robot reaches its target in 0.37 s instead of 0.86 s, on average over 4 places.",
    ),
    "not enough": (
        ([OPEN, change([1.0, 1.2, 1.1], [1.3, 1.0, 1.2], TIME)], ruled((1, 0.5), (-1, 0.6))),
        Answer.CANNOT_TELL,
        "3 trainings of each reward are not enough to tell.",
    ),
    "one": (([change([0.5], [0.6])],), Answer.CANNOT_TELL, "1 training of each reward is not enough to tell."),
    "unlike numbers": (([change([0.5, 0.6], [0.6])],), Answer.CANNOT_TELL, "These trainings are not enough to tell."),
    "a plan that is not trained to its end has no word": (
        ([MORE], Ruling(missing=4)),
        Answer.INTERIM,
        "6 trainings are compared, 4 are missing. No test is made without ",
    ),
    "equal steps are equal by no test": (
        ([SAME], ruled((0, 1.0)), "robot", "", True),
        Answer.NO_DIFFERENCE,
        "The robot takes the same steps with either reward, bit for bit.",
    ),
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
    "a training that ended for a small difference has the margin of the plan": (
        ([OPEN], Ruling(0.5, 0.5, of_measures=(0.5,), signs=(1,), small=0.1)),
        Answer.NO_DIFFERENCE,
        "Success differs by less than 10 points, also where trainings fail that were not seen.",
    ),
    "neither learns": (
        ([change([0.0] * 60, [0.01] * 60)], ruled(FAILS)),
        Answer.NEITHER_LEARNS,
        "Success is below 10% with either reward, also where trainings succeed that were not seen.",
    ),
    "neither of a few": (
        ([change([0.0] * 3, [0.01] * 3)], ruled(FAILS)),
        Answer.CANNOT_TELL,
        "Train longer, or with another algorithm.",
    ),
    "an end that is apart is not called no difference": (
        ([change([1.1, 1.2, 1.3], [1.9, 2.0, 2.1], HEIGHT), SOONER], ruled((1, 0.2), PASSES)),
        Answer.LEARNS_FASTER,
        " Whether the end differs too cannot be told.",
    ),
}
PARTS = ("learning more slowly", "a difference of", "a plan", "neither learns", "an end", "these trainings")
"""Rows that have a part of the text."""


@pytest.mark.parametrize("row", SAID)
def test_the_answer_is_said(row):
    """In whole sentences."""
    asked, answer, lead = SAID[row]
    found = told(*asked)
    assert found[0] == answer
    assert lead in found[1] if row.startswith(PARTS) else lead == found[1]


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
