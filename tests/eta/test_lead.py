"""The answer in a sentence: what it says, and that it never says more than the headline."""

import re

import numpy as np
from hypothesis import given, strategies as st

from harness.eta.behaviour_change import TRAINING, Change, Quantity, change_of
from harness.eta.headline import UNMEASURED, Answer, key_of, name_of
from harness.eta.judge import DECIDED, judge
from harness.eta.lead import lead_of
from harness.eta.splits import Names
from harness.eta.swaps import swaps_of
from harness.eta.verdict.ruling import Ruling

NAMES = Names("base", "mine")
SUCCESS = Quantity("success_rate", "", "higher", "deterministic", episodes=100)
TIME = Quantity("time_to_target", "s", "lower", "deterministic")
SPEED = Quantity("success_rate", "", "higher", TRAINING, episodes=100)
HEIGHT = Quantity("tip_height", "m", "higher", "deterministic")
CLAIM = re.compile(r"\b([Bb]etter|[Ww]orse|helps|hurts|reaches|succeeds|faster|slowly)\b")


def change(measure: Quantity, baseline: list[float], proposed: list[float]) -> Change:
    """The change of a measure, from the values of each seed."""
    one, other = dict(enumerate(baseline)), dict(enumerate(proposed))
    return change_of(measure, one, other, swaps_of(range(min(len(one), len(other)))))


def told(
    changes: list[Change], ruling: Ruling, subject: str = "robot", where: str = "", same_steps: bool = False
) -> tuple[Answer, str]:
    """The answer, and what is said of it."""
    found = judge(NAMES, changes, "", ruling, where=where, same_steps=same_steps)
    return found.answer, lead_of(found, changes, ruling, subject, where, same_steps=same_steps)


def ruled(signs: tuple[int, ...], *p_values: float) -> Ruling:
    """Each measure has its sign and its corrected p."""
    return Ruling(min(p_values), min(p_values), of_measures=p_values, signs=signs)


FAST = change(TIME, [0.84, 0.86, 0.88], [0.36, 0.37, 0.38])
SAME = change(SUCCESS, [0.98, 0.99, 1.0], [1.0, 0.99, 0.98])
MORE = change(SUCCESS, [0.5, 0.6, 0.7], [0.9, 0.91, 0.92])
OPEN = change(SUCCESS, [0.5, 0.6, 0.7], [0.55, 0.7, 0.6])


def test_a_decided_answer_says_what_the_robot_does_instead():
    """And of the other measure that nothing was found."""
    assert told([SAME, FAST], ruled((1, 1), 0.9, 0.004)) == (
        Answer.HELPS,
        "The robot reaches its target in 0.37 s instead of 0.86 s. No difference in success was found.",
    )


def test_a_second_measure_that_is_better_is_told_too():
    """In a sentence of its own."""
    _, lead = told([MORE, FAST], ruled((1, 1), 0.01, 0.01))
    assert lead == (
        "The robot succeeds in 91 % instead of 60 % of its episodes. The robot also reaches its target in 0.37 s "
        "instead of 0.86 s."
    )


def test_what_is_worse_stands_beside_what_is_better():
    """That of the measure that says most first: the reader decides."""
    answer, lead = told([change(SUCCESS, [0.9] * 3, [0.5] * 3), FAST], ruled((-1, 1), 0.02, 0.01))
    assert (answer, lead) == (
        Answer.MIXED,
        "Better: time to the target, 0.37 s instead of 0.86 s. Worse: success, 50 % instead of 90 %.",
    )


def test_learning_faster_says_that_the_end_is_open():
    """In a sentence of its own."""
    sooner = change(SPEED, [0.3, 0.4, 0.5], [0.6, 0.7, 0.8])
    assert told([SAME, sooner], ruled((1, 1), 0.9, 0.01)) == (
        Answer.LEARNS_FASTER,
        "The robot learns faster: 70 % instead of 40 % of its episodes succeed while training. At the end no "
        "difference was found.",
    )
    assert "The robot learns more slowly: " in told([SAME, sooner], ruled((1, -1), 0.9, 0.01))[1]


def test_a_difference_below_its_margin_is_little():
    """That of the measure that decided."""
    quicker = change(TIME, [2.0, 2.01, 2.02], [1.89, 1.9, 1.91])
    assert told([SAME, quicker], ruled((1, 1), 0.9, 0.01))[1].startswith(
        "The robot reaches its target in 1.90 s instead of 2.01 s. That is little: less than 10% of the time."
    )


def test_a_measure_of_an_environment_has_its_name_and_unit():
    """Nothing is said of a target."""
    raised = change(HEIGHT, [1.1, 1.2, 1.3], [1.9, 2.0, 2.1])
    assert told([raised], ruled((1,), 0.01), "agent")[1] == "Tip height is 2.00 m instead of 1.20 m."


def test_over_several_places_it_says_so():
    """Behind what was measured."""
    _, lead = told([FAST], ruled((1,), 0.01), where="over 4 places")
    assert lead == "The robot reaches its target in 0.37 s instead of 0.86 s, on average over 4 places."


def test_cannot_tell_says_that_it_is_not_enough():
    """Of as many trainings, of one, and of unlike numbers."""
    answer, lead = told([OPEN, change(TIME, [1.0, 1.2, 1.1], [1.3, 1.0, 1.2])], ruled((1, -1), 0.5, 0.6))
    assert (answer, lead) == (Answer.CANNOT_TELL, "3 trainings of each reward are not enough to tell.")
    one, odd = change(SUCCESS, [0.5], [0.6]), change(SUCCESS, [0.5, 0.6], [0.6])
    assert told([one], Ruling())[1] == "1 training of each reward is not enough to tell."
    assert told([odd], Ruling())[1] == "These trainings are not enough to tell."


def test_a_plan_that_is_not_trained_to_its_end_has_no_word():
    """How many are to come, and how to look on the way."""
    answer, lead = told([MORE], Ruling(missing=4))
    assert answer == Answer.INTERIM
    assert lead.startswith("6 trainings are compared, 4 of the plan are still to come. No test is made before ")


def test_equal_steps_are_equal():
    """Bit for bit, by no test."""
    answer, lead = told([SAME], ruled((0,), 1.0), same_steps=True)
    assert (answer, lead) == (Answer.NO_DIFFERENCE, "The robot takes the same steps with either reward, bit for bit.")


def test_a_small_difference_has_its_margins():
    """Those of the test."""
    around = list(0.9 + 0.01 * np.linspace(-1.0, 1.0, 80))
    near = change(SUCCESS, around, around[::-1])
    assert told([near], ruled((1,), 0.9)) == (
        Answer.NO_DIFFERENCE,
        "The rewards differ by less than 5 points of success, also where trainings fail that were not seen.",
    )
    quick = change(TIME, around, around[::-1])
    assert told([quick], ruled((1,), 0.9))[1] == "The rewards differ by less than 10% of the time."


def test_a_training_that_ended_for_a_small_difference_has_its_margin():
    """That of the plan."""
    ruling = Ruling(0.5, 0.5, of_measures=(0.5,), signs=(1,), small=0.1)
    assert told([OPEN], ruling)[1] == (
        "Success differs by less than 10 points, also where trainings fail that were not seen."
    )


def test_neither_learns_says_what_to_do():
    """Train on."""
    answer, lead = told([change(SUCCESS, [0.0] * 60, [0.01] * 60)], ruled((1,), 0.9))
    assert answer == Answer.NEITHER_LEARNS
    assert lead.startswith("Success is below 10% with either reward, also where trainings succeed that were not seen.")
    few = told([change(SUCCESS, [0.0] * 3, [0.01] * 3)], ruled((1,), 0.9))
    assert few == (Answer.CANNOT_TELL, "Train longer, or with another algorithm.")


def test_in_a_race_the_race_decides():
    """Nothing is claimed."""
    answer, lead = told([MORE], Ruling(instead="The race decides."))
    assert (answer, lead) == (Answer.RACED, "The race decides; this comparison by itself is no test.")


def test_nothing_measured_has_its_reason():
    """That of the headline."""
    assert told([], Ruling()) == (Answer.CANNOT_TELL, UNMEASURED)


def test_names_are_those_of_sentences():
    """Without underscores; success while training is another measure than success, in words and for programs."""
    sooner = change(SPEED, [1.0], [1.0])
    assert [name_of(it) for it in (SAME, sooner, FAST, change(HEIGHT, [1.0], [1.0]))] == [
        "success",
        "success while training",
        "time to the target",
        "tip height",
    ]
    assert [key_of(it) for it in (SAME, sooner)] == ["success_rate", "success_rate while training"]


@given(
    st.lists(st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)), min_size=1, max_size=8),
    st.floats(0.0, 1.0),
    st.sampled_from([-1, 0, 1]),
)
def test_no_claim_without_a_test(values, p, sign):
    """No word of better or worse stands where the test does not say so, and no bracket anywhere.

    Where both fail at the task, a sentence says what the test says, and the answer is another one.
    """
    shown = change(SUCCESS, *map(list, zip(*values, strict=True)))
    answer, lead = told([shown], ruled((sign,), p))
    is_decided = p <= 0.05 and sign != 0
    fails = max(shown.baseline, shown.proposed) < 0.1
    assert (answer in DECIDED) == (is_decided and not fails)
    assert bool(CLAIM.search(lead)) == is_decided
    assert not re.search(r"[][()]", lead)


def test_a_measure_whose_interval_leaves_out_zero_cannot_be_told():
    """To have found no difference would be odd beside it."""
    _, lead = told([change(SUCCESS, [0.1, 0.11, 0.12], [0.9, 0.91, 0.92]), FAST], ruled((1, 1), 0.2, 0.01))
    assert lead.endswith(" Whether success differs cannot be told.")
    changes = [change(SUCCESS, [0.1, 0.11, 0.12], [0.9, 0.91, 0.92]), change(SPEED, [0.1, 0.11, 0.1], [0.5, 0.51, 0.5])]
    answer, lead = told(changes, ruled((1, 1), 0.2, 0.01))
    assert answer is Answer.LEARNS_FASTER
    assert lead.endswith(" Whether the end differs too cannot be told.")
