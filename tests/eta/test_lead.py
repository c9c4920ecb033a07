"""The answer in a sentence: what it says, and that it never says more than the headline."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.eta.behaviour_change import Change, Measure, change_of
from harness.eta.headline import UNMEASURED, Answer, Names, judge
from harness.eta.lead import at_most_text, lead_of, name_of, short_values
from harness.eta.swaps import swaps_of
from harness.eta.verdict.ruling import Ruling

NAMES = Names("base", "mine")
SUCCESS = Measure("success_rate", "", "higher", "deterministic", episodes=100)
TIME = Measure("time_to_target", "s", "lower", "deterministic")
HEIGHT = Measure("tip_height", "m", "higher", "deterministic")
CLAIM = re.compile(r"\b(better|worse|helps|hurts|reaches|succeeds|faster)\b")


def change(measure: Measure, baseline: list[float], proposed: list[float]) -> Change:
    """The change of a measure, from the values of each seed."""
    one, other = dict(enumerate(baseline)), dict(enumerate(proposed))
    return change_of(measure, one, other, swaps_of(range(len(baseline))))


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


def test_the_opposite_of_another_measure_is_told():
    """Both stand: the reader decides."""
    answer, lead = told([change(SUCCESS, [0.9] * 3, [0.5] * 3), FAST], ruled((-1, 1), 0.02, 0.01))
    assert answer == Answer.HELPS
    assert lead.endswith("But success is worse: 50 % instead of 90 %.")


def test_a_measure_of_an_environment_has_its_name_and_unit():
    """Nothing is said of a target."""
    raised = change(HEIGHT, [1.1, 1.2, 1.3], [1.9, 2.0, 2.1])
    assert told([raised], ruled((1,), 0.01), "agent")[1] == "Tip height is 2.0 m instead of 1.2 m."


def test_over_several_places_it_says_so():
    """Behind what was measured."""
    _, lead = told([FAST], ruled((1,), 0.01), where="over 4 places")
    assert lead == "The robot reaches its target in 0.37 s instead of 0.86 s, on average over 4 places."


def test_cannot_tell_says_how_many_trainings_would_tell():
    """Where a number can be planned."""
    answer, lead = told([OPEN, change(TIME, [1.0, 1.2, 1.1], [1.3, 1.0, 1.2])], ruled((1, -1), 0.5, 0.6))
    assert answer == Answer.CANNOT_TELL
    assert re.fullmatch(r"3 trainings of each reward are not enough: it takes [\d,]+ to [\d,]+ to tell\.", lead)


def test_one_training_is_not_enough():
    """It has no interval, and nothing can be planned."""
    assert told([change(SUCCESS, [0.5], [0.6])], Ruling())[1] == "1 training of each reward is not enough."


def test_how_large_a_difference_can_be_is_told_either_way():
    """Of each measure that has an interval."""
    later = change(TIME, [1.0, 1.2, 1.1], [1.3, 1.0, 1.2])
    assert re.fullmatch(
        r"So far, success differs by at most \d+ points and time to target by at most [\d.]+ s, either way\.",
        at_most_text([OPEN, later]),
    )
    assert at_most_text([change(SUCCESS, [0.5], [0.6])]) == ""


def test_a_share_differs_by_100_points_at_most():
    """However wide its interval is."""
    assert "at most 100 points" in at_most_text([change(SUCCESS, [0.0, 1.0, 0.0], [1.0, 0.0, 1.0])])


def test_equal_steps_are_equal():
    """Bit for bit, by no test."""
    answer, lead = told([SAME], ruled((0,), 1.0), same_steps=True)
    assert (answer, lead) == (Answer.NO_DIFFERENCE, "The robot takes the same steps with either reward, bit for bit.")


def test_a_small_difference_has_its_margins():
    """Those of the test."""
    around = list(0.9 + 0.01 * np.linspace(-1.0, 1.0, 40))
    near = change(SUCCESS, around, around[::-1])
    assert told([near], ruled((1,), 0.9)) == (
        Answer.NO_DIFFERENCE,
        "The rewards differ by less than 5 points of success.",
    )


def test_a_training_that_ended_for_a_small_difference_has_its_margin():
    """That of the plan."""
    ruling = Ruling(0.5, 0.5, of_measures=(0.5,), signs=(1,), small=0.1)
    assert told([OPEN], ruling)[1] == "Success differs by less than 10 points."


def test_neither_learns_says_what_to_do():
    """Train on."""
    answer, lead = told([change(SUCCESS, [0.0, 0.0], [0.01, 0.0])], ruled((1,), 0.9))
    assert answer == Answer.NEITHER_LEARNS
    assert lead.startswith("Success stays below 10% with either reward.")


def test_in_a_race_the_race_decides():
    """What was seen is told, without a claim."""
    answer, lead = told([MORE], Ruling(instead="The race decides."))
    assert (answer, lead) == (Answer.RACED, "Success 91 % instead of 60 %. The race decides.")


def test_nothing_measured_has_its_reason():
    """That of the headline."""
    assert told([], Ruling()) == (Answer.CANNOT_TELL, UNMEASURED)


@pytest.mark.parametrize(
    ("measure", "values", "shown"),
    [
        (SUCCESS, (0.99, 1.0), ("99", "100 %")),
        (SUCCESS, (0.991, 0.994), ("99.1", "99.4 %")),
        (SUCCESS, (0.75, 0.75), ("75", "75 %")),
        (TIME, (0.8643, 0.3691), ("0.86", "0.37 s")),
        (TIME, (9.96, 12.3), ("10", "12 s")),
        (HEIGHT, (1234.5, -0.0123), ("1,234", "-0.012 m")),
    ],
)
def test_values_have_as_many_digits_as_tell_them_apart(measure, values, shown):
    """Two, or three where two are the same; a share has whole per cent."""
    one, other = values
    assert short_values(change(measure, [one] * 2, [other] * 2)) == shown


def test_names_are_those_of_sentences():
    """Without underscores."""
    assert [name_of(it) for it in (SAME, FAST, change(HEIGHT, [1.0], [1.0]))] == [
        "success",
        "time to target",
        "tip height",
    ]


@given(
    st.lists(st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)), min_size=1, max_size=8),
    st.floats(0.0, 1.0),
    st.sampled_from([-1, 0, 1]),
)
def test_no_claim_without_a_test(values, p, sign):
    """No word of better or worse stands where the test does not say so, and no bracket anywhere."""
    shown = change(SUCCESS, *map(list, zip(*values, strict=True)))
    answer, lead = told([shown], ruled((sign,), p))
    is_decided = answer in (Answer.HELPS, Answer.HURTS)
    assert is_decided == (p <= 0.05 and sign != 0)
    assert bool(CLAIM.search(lead)) == is_decided
    assert not re.search(r"[][()]", lead)
