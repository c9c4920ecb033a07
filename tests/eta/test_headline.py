"""The answers and their whole sentences: every wording there is, read as a person reads it."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from harness.eta import (
    BB,
    BK,
    KB,
    KK,
    UNMEASURED,
    Answer,
    LookRuling,
    Quantity,
    Ruling,
    Verdict,
    change_of,
    curve_of,
    decompose,
    swaps_of,
)
from harness.eta.power import seeds_to_tell
from tests.eta.headlines import CLAIM, DECIDED, NAMES, PAIRS, SUCCESS, TIME, change, headline_of, ruling_of
from tests.results.told import SPEED

SEEDS = 10
SAME = (-100.0, 100.0)
HITS = Quantity("ground_hits", "", "lower", "deterministic")


def group(sums, seeds=2):
    """The curve of equal runs whose I_N and I_P are `sums`."""
    negative, positive = sums
    return curve_of([np.array([negative, positive - negative])] * seeds)


def compared(bb=SAME, bk=SAME, kb=SAME, kk=SAME, seeds=2):
    """The four scored groups by their I_N and I_P; two seeds have no interval."""
    return decompose({pair: group(of, seeds) for pair, of in {BB: bb, BK: bk, KB: kb, KK: kk}.items()})


def about(mean, seeds=SEEDS, width=0.02):
    """Values around a mean."""
    return list(mean + width * np.linspace(-1.0, 1.0, seeds))


def moved(one, other, measure=SUCCESS, p=1.0):
    """From values around one mean to values around another."""
    return change(about(one), about(other), measure, p)


def told(*changes, asked=1):
    """Of a comparison without any difference in reward."""
    return headline_of(compared(), changes, asked)


def ruled(*changes, where="", is_opposed=False, **fields):
    """Of changes of any measures, with the p-values that they have; more of the ruling as it is given."""
    return Verdict(NAMES, changes, replace(ruling_of(changes), **fields), where, is_opposed=is_opposed).headline("")


def so_far(*changes, **fields):
    """Of changes that labels dealt anew tell apart, and no bound."""
    return ruled(*changes, beyond=(False,) * len(changes), **fields)


BETTER = moved(0.5, 0.9, p=0.01)
"""A change of success that passes."""
ALIKE = moved(0.99, 0.99)


# A difference


FEW, TENTH, STEADY = [0.01, 0.0] * 2, [0.1, 0.12] * 2, about(0.5, 60, 0.001)
ANSWERS = {
    "only the training was measured": (ruled(moved(0.4, 0.6, SPEED, p=0.01)), Answer.HELPS),
    "a test goes before a margin": (told(change([1.0] * 20, [0.99] * 20, p=0.001)), Answer.HURTS),
    "other measures stand in the table": (
        told(moved(0.9, 0.1, HITS, p=0.001), change(about(0.5, width=0.3), about(0.6))),
        Answer.CANNOT_TELL,
    ),
    "the time alone": (told(moved(7.0, 5.0, TIME, p=0.01)), Answer.HELPS),
    "the time alone is alike": (told(change(about(7.0, 60), about(7.0, 60), TIME)), Answer.NO_DIFFERENCE),
    "one ahead and one behind": (so_far(moved(0.5, 0.9, p=0.01), moved(5.0, 7.0, TIME, p=0.01)), Answer.CANNOT_TELL),
    "alike by the bound, though labels tell": (so_far(change([1.0] * 70, [0.99] * 70, p=0.01)), Answer.NO_DIFFERENCE),
    "from next to nothing to a tenth": (told(change(FEW, TENTH, p=0.029)), Answer.HELPS),
    "from a tenth to next to nothing": (told(change(TENTH, FEW, p=0.029)), Answer.HURTS),
    "success alike, the time unknown": (
        told(change([1.0] * 60, [1.0] * 60), change(about(7.0, 60, 6.0), about(7.0, 60, 6.0)[::-1], TIME)),
        Answer.CANNOT_TELL,
    ),
    "between two looks only their own test says it": (ruled(change(STEADY, STEADY), has_plan=True), Answer.CANNOT_TELL),
}


@pytest.mark.parametrize(("found", "answer"), ANSWERS.values(), ids=ANSWERS)
def test_answers(found, answer):
    """By the measures that decide, their tests and their margins."""
    assert found.answer is answer


@pytest.mark.parametrize(("proposed", "answer"), [(9.0, "hurts"), (5.0, "helps")])
def test_time_decides_where_success_does_not(proposed, answer):
    """Less time is better; its unit is told, and the measure."""
    found = told(ALIKE, change(about(7.0, width=0.1), about(proposed, width=0.2), TIME, p=0.01))
    assert (found.answer.value, found.decided_by) == (answer, "time_to_target")
    assert f": {proposed:.2f} s instead of 7.00 s." in found.robot
    assert f" mine {answer}, decided by the time to the target. One training more" in found.robot


def test_success_while_training_alone_may_say_that_it_learns_slower():
    """The measure that decided has its name."""
    found = ruled(ALIKE, moved(0.4, 0.2, SPEED, p=0.01))
    assert (found.answer, found.decided_by) == (Answer.LEARNS_SLOWER, "success_rate while training")
    assert "mine learns slower, decided by success while training; whether the end differs" in found.robot


def test_a_difference_below_its_margin_is_not_little_beside_one_beyond_it():
    """Though its measure decided."""
    assert "by little" not in told(BETTER, moved(2.01, 1.90, TIME, p=0.001)).robot


def test_trainings_need_not_be_as_many():
    """Both numbers stand there."""
    assert "; 10 trainings with base, 5 with mine. " in told(change(about(7.0), about(5.0, 5), TIME, p=0.01)).robot


# No difference


def test_a_difference_between_two_that_certainly_fail_stands_beside_the_word():
    """From 1 to 5 % of the episodes helps nobody; that a test tells the two apart is said, with its p-value."""
    found = told(change([0.01, 0.0] * 30, [0.05, 0.04] * 30, p=0.029))
    assert (found.answer, found.decided_by) == (Answer.NEITHER_LEARNS, None)
    assert " not seen (95%). The two differ all the same: mine is better in success." in found.robot


def test_where_one_learns_they_are_counted_by_failures():
    """One above a tenth is enough."""
    assert "failed" in told(change(about(0.02), about(0.12, width=0.3), p=0.2)).robot


def test_a_few_perfect_trainings_are_not_certain():
    """No spread is no proof: 1 - 0.05 ** (1 / 6) of all trainings may fail."""
    odd = told(change([1.0] * 6, [1.0] * 4))
    assert "but 6 with base and 4 with mine cannot rule out that up to 39% and 53% fail." in odd.robot


# No answer


def test_a_plan_counts_the_unseen_training_of_either_reward():
    """Near the bad end that of the reward behind is the farther one: it is the same read from the other end."""
    risen, fallen = (
        told(change(about(before, width=0.1), about(after, width=0.1), p=0.4), asked=28).seeds_to_decide
        for before, after in ((0.1, 0.4), (0.9, 0.6))
    )
    assert risen == fallen


def test_where_all_lie_within_their_margins_the_plan_is_to_show_that():
    """By every measure; so many trainings do show it."""
    both = [change([1.0] * 40, [1.0] * 40), change([7.0] * 40, [7.0] * 40, TIME)]
    found = told(*both)
    assert (found.answer, found.seeds_to_decide[0]) == (Answer.CANNOT_TELL, found.seeds_to_decide[1])
    assert f"If nothing differs, {found.seeds_to_decide[0]} trainings of each reward" in found.robot
    enough = found.seeds_to_decide[0]
    assert told(*(change([it.baseline] * enough, [it.baseline] * enough, it.measure) for it in both)).answer is (
        Answer.NO_DIFFERENCE
    )


def test_trainings_without_a_value_come_before_more_of_them():
    """They count where they speak against a word, and so many more of them as well."""
    lost = dict(enumerate([0.9] * 8 + [None, None]))
    found = told(replace(change_of(SUCCESS, dict(enumerate(about(0.5))), lost, swaps_of(range(8))), corrected=1.0))
    assert "cannot be told from 10 trainings with base, 8 of 10 with mine (the others left no value)." in found.robot
    assert "2 of 10 trainings failed with mine, 5 of 10 with base (2 and 0 left no value)" in found.robot
    assert found.robot.endswith("find out first why they have none.")
    assert found.seeds_to_decide is None


def test_a_number_of_trainings_that_nobody_knows_is_no_plan():
    """Above a factor of ten between its ends."""
    few = told(change([0.2, 0.6], [0.5, 0.8])).robot
    assert few.endswith("So few trainings do not tell how many would be enough.")


def test_in_looks_few_trainings_are_no_warning():
    """The plan says when to ask again; where places have seeds of their own, two of each can decide."""
    planned = LookRuling(0.5, 0.5, of_measures=(0.5,), signs=(1,))
    assert "Fewer than" not in Verdict(NAMES, [change([0.5, 0.6], [0.6, 0.7])], planned).headline("").robot


def test_one_training_that_is_missing_is_no_plural():
    """No seeds are foretold either."""
    found = ruled(moved(0.5, 0.9), missing="1 training is missing")
    assert (found.decided_by, found.seeds_to_decide) == (None, None)
    assert "1 training is missing" in found.robot


def test_one_training_has_no_interval_and_no_plan():
    """Nor a p-value."""
    found = told(change([0.1], [0.9], p=None))
    assert found.seeds_to_decide is None
    assert found.robot.startswith("Success +80.0 points: 90.0% with mine, 10.0% with base; 0 of 1 trainings failed")
    assert "cannot be told from 1 training of each reward." in found.robot


@pytest.mark.parametrize(
    "changes", [[], [moved(0.5, 0.9, HITS)], [change_of(SUCCESS, {0: None}, {0: 0.5}, swaps_of([0]))]]
)
def test_behaviour_that_was_not_measured(changes):
    """Without a success rate or a time under both rewards there is nothing to rest on; a given reason is told."""
    found = headline_of(compared(), changes)
    assert (found.answer, found.robot) == (Answer.CANNOT_TELL, UNMEASURED)
    assert Verdict(NAMES, [], Ruling()).headline("number", "Nobody looked.").robot == "Nobody looked."


@given(
    PAIRS,
    st.none() | st.floats(0.0, 1.0),
    st.sampled_from([SUCCESS, TIME, SPEED]),
)
def test_no_claim_without_a_corrected_p_value(pairs, p, measure):
    """No word of better or worse, helps or hurts, faster or slower, stands where no bound says so."""
    found = ruled(change(*zip(*pairs, strict=True), measure, p))
    sentences = found.robot.replace("Whether mine helps or hurts", "")
    if p is None or p > 0.05:
        assert found.answer in (Answer.CANNOT_TELL, Answer.NO_DIFFERENCE, Answer.NEITHER_LEARNS)
        assert not CLAIM.search(sentences + found.number)
    assert (found.answer in DECIDED or "The two differ" in sentences) == bool(CLAIM.search(sentences))


# The number


# The trial that all of this is for: 10 runs each, K2 = 1.5
TRIAL = {"bb": (-1000.0, 1000.0), "bk": (-1430.0, 500.0), "kb": (-60.0, 46_500.0), "kk": (-90.0, 25_600.0)}
NUMBERS = {
    "a triumph that is all ruler": (
        compared(**TRIAL),
        "I_P with mine is 25.6 times that with base: x 48.8 by rescaling alone (its ruler), "
        "x 0.525 by other runs (its behaviour).",
    ),
    "intervals stand behind their values": (
        compared(kb=(-50.0, 200.0), kk=(-50.0, 200.0), seeds=3),
        "I_P with mine is 2.00 [2.00, 2.00] times that with base: x 2.00 [2.00, 2.00] by rescaling alone "
        "(its ruler), x 1.00 [1.00, 1.00] by other runs (its behaviour).",
    ),
    "an index that says little has the reason without a number": (
        compared(kb=(-100.0, 4000.0), kk=(-100.0, 1.0)),
        "eta_P says little: I_P of the proposed reward is near zero beside that of the baseline runs under the "
        "proposed reward.",
    ),
    "an index that is not defined": (
        compared(bb=(-100.0, 0.0)),
        "eta_P n/a: I_P of the baseline is 0: its mean accumulated reward is never positive.",
    ),
    "a part near zero is not split": (
        compared(bk=(-100.0, 0.5)),
        "I_P with mine is 1.00 times that with base; not split: I_P of the proposed runs under the baseline reward is "
        "near zero beside that of the baseline.",
    ),
    "what was not scored again": (
        decompose({BB: group(SAME), KK: group((-100.0, 200.0))}, missing="base.csv has no distances to score again"),
        "I_P with mine is 2.00 times that with base; not split: base.csv has no distances to score again.",
    ),
}


@pytest.mark.parametrize(("found", "said"), NUMBERS.values(), ids=NUMBERS)
def test_the_number_is_said(found, said):
    """Without a word of better."""
    assert headline_of(found).number.endswith(said)
    assert not CLAIM.search(said)


def test_both_indices_are_told():
    """I_N first."""
    said = headline_of(compared(**TRIAL)).number
    assert said.startswith("I_N with mine is 0.0900 times that with base: x 0.0615 by ")
    assert said.index("I_N with mine") < said.index("I_P with mine")


def test_behaviour_that_depends_on_the_judge_is_flagged():
    """At the end, with the index's name; it is no claim about the robot."""
    said = headline_of(compared(bk=(-100.0, 200.0), kb=(-100.0, 400.0), kk=(-100.0, 200.0))).number
    assert said.endswith(
        " eta_P: the behaviour depends on who judges it: x 2 under the baseline reward, x 0.5 under the proposed one."
    )
    assert not CLAIM.search(said)


@pytest.mark.parametrize("seeds", [1, 2, 4])
def test_headline_is_whole_sentences(seeds):
    """Whatever the notes are."""
    found = headline_of(compared(**TRIAL, seeds=seeds), [change(about(0.5, seeds), about(0.4, seeds))])
    for said in (found.robot, found.number):
        assert said.endswith(".")
        assert not re.search(r"\n|\.\.|  |None|nan", said)


def test_one_measure_that_tells_is_enough():
    """The one that takes fewest."""
    success, speed = change(about(0.5, width=0.1), about(0.55, width=0.2)), moved(0.4, 0.6, SPEED)
    alone, beside = ruled(success), ruled(success, speed)
    assert alone.seeds_to_decide == seeds_to_tell(0.05, success.spread, SEEDS, 0.95, 0.55)
    assert beside.seeds_to_decide == (SEEDS + 1, SEEDS + 1)
