"""What a comparison comes to, in words: every wording there is, read as a person reads it."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.eta.behaviour_change import Change, Measure, change_of
from harness.eta.curve import GroupCurve, curve_of
from harness.eta.decompose import decompose
from harness.eta.headline import UNMEASURED, Answer, Headline, Names, judge, margin_of
from harness.eta.power import seeds_to_tell
from harness.eta.scored_sums import BB, BK, KB, KK
from harness.eta.splits import Decomposition
from harness.eta.swaps import swaps_of
from harness.eta.verdict.looks import LookRuling
from harness.eta.verdict.ruling import Ruling
from tests.eta.headlines import headline_of, ruling_of

Sums = tuple[float, float]
NAMES = Names("base", "mine")
SEEDS = 10
SAME: Sums = (-100.0, 100.0)
SUCCESS = Measure("success_rate", "", "higher", "deterministic", 100)
TIME = Measure("time_to_target", "steps", "lower", "deterministic")
HITS = Measure("ground_hits", "", "lower", "deterministic")
CLAIM = re.compile(r"\b(better|worse|helps|hurts)\b")


def group(sums: Sums, seeds: int) -> GroupCurve:
    """The curve of equal runs whose I_N and I_P are `sums`."""
    negative, positive = sums
    return curve_of([np.array([negative, positive - negative])] * seeds)


def compared(bb: Sums = SAME, bk: Sums = SAME, kb: Sums = SAME, kk: Sums = SAME, seeds: int = 2) -> Decomposition:
    """The four scored groups by their I_N and I_P; two seeds have no interval."""
    sums = {BB: bb, BK: bk, KB: kb, KK: kk}
    return decompose({pair: group(of, seeds) for pair, of in sums.items()})


def change(baseline: list[float], proposed: list[float], measure: Measure = SUCCESS, p: float | None = 1.0) -> Change:
    """Of seeds 0, 1, 2 ..., with this corrected p-value."""
    one, other = dict(enumerate(baseline)), dict(enumerate(proposed))
    return replace(change_of(measure, one, other, swaps_of(range(len(baseline)))), corrected=p)


def about(mean: float, seeds: int = SEEDS, width: float = 0.02) -> list[float]:
    """Values around a mean."""
    return list(mean + width * np.linspace(-1.0, 1.0, seeds))


def told(*changes: Change, asked: int = 1) -> Headline:
    """Of a comparison without any difference in reward."""
    return headline_of(NAMES, compared(), changes, asked)


# The robot


def test_reward_that_helps():
    """Whose value is whose, the difference's interval, and how sure it is."""
    found = told(change(about(0.5), about(0.9), p=0.0123))
    assert (found.answer, found.decided_by) == (Answer.HELPS, "success_rate")
    assert found.robot == (
        "mine helps: success rate 90.0% with mine, 50.0% with base (difference +33.1 to +46.9 points); 10 seeds, "
        "corrected p 0.012."
    )


def test_reward_that_hurts():
    """A p-value below a thousandth is not told to its last digit."""
    found = told(change(about(0.9), about(0.5), p=0.0002))
    assert (found.answer, found.decided_by) == (Answer.HURTS, "success_rate")
    assert found.robot.startswith(
        "mine hurts: success rate 50.0% with mine, 90.0% with base (difference -46.9 to -33.1"
    )
    assert found.robot.endswith("; 10 seeds, corrected p < 0.001.")


@pytest.mark.parametrize(("proposed", "answer", "verb"), [(9.0, "hurts", "hurts"), (5.0, "helps", "helps")])
def test_time_decides_where_success_does_not(proposed: float, answer: str, verb: str):
    """Less time is better; its unit is told."""
    time = change(about(7.0, width=0.1), about(proposed, width=0.2), TIME, p=0.01)
    found = told(change(about(0.99), about(0.99)), time)
    assert (found.answer.value, found.decided_by) == (answer, "time_to_target")
    assert found.robot.startswith(f"mine {verb}: time to target {proposed:g} steps with mine, 7 steps with base (diff")
    assert " steps); 10 seeds, " in found.robot


def test_the_measure_that_says_most_decides_and_the_other_is_told():
    """Who fails less and takes longer: by the smaller p, and the sentence says the opposite too."""
    slower = change(about(7.0), about(9.0), TIME, p=0.001)
    found = told(slower, change(about(0.5), about(0.9), p=0.04))
    assert (found.answer, found.decided_by) == (Answer.HURTS, "time_to_target")
    assert " But the opposite holds of another measure: success rate 90.0% with mine" in found.robot


def test_a_measure_that_does_not_pass_is_no_opposite():
    """It may go either way by chance."""
    found = told(change(about(7.0), about(9.0), TIME, p=0.001), change(about(0.5), about(0.9), p=0.3))
    assert "opposite" not in found.robot


def test_where_neither_learns_there_is_nothing_to_compare():
    """Both succeed in less than a tenth of the episodes."""
    found = told(change(about(0.02), about(0.08), p=0.2))
    assert found.answer == Answer.NEITHER_LEARNS
    assert found.robot.startswith("Neither base nor mine teaches the task: success rate 8.0% with mine, 2.0% with base")


def test_where_one_learns_it_is_no_such_case():
    """One above a tenth is enough."""
    assert told(change(about(0.02), about(0.12, width=0.3), p=0.2)).answer == Answer.CANNOT_TELL


def test_a_difference_too_small_to_go_on_for_ends_the_training():
    """Where a plan of several looks said so."""
    ruling = Ruling(0.5, 0.5, of_measures=(0.5,), signs=(1,), small=0.1)
    found = judge(NAMES, [change(about(0.6), about(0.61))], "number", ruling)
    assert found.answer == Answer.NO_DIFFERENCE
    assert found.robot.startswith("mine differs by less than 10 points: success rate 61.0% with mine")


def test_in_looks_few_seeds_are_no_warning():
    """The plan says when to ask again; where places have seeds of their own, two of each can decide."""
    few = [change([0.5, 0.6], [0.6, 0.7])]
    ruling = Ruling(0.5, 0.5, of_measures=(0.5,), signs=(1,))
    planned = LookRuling(0.5, 0.5, of_measures=(0.5,), signs=(1,))
    assert "Fewer than 4 seeds cannot show anything here" in judge(NAMES, few, "", ruling).robot
    assert "Fewer than" not in judge(NAMES, few, "", planned).robot


def test_another_test_that_decides_is_named():
    """In a race a comparison by itself is no test, whatever its p."""
    ruling = Ruling(0.001, 0.001, of_measures=(0.001,), signs=(1,), instead="The race decides.")
    found = judge(NAMES, [change(about(0.5), about(0.9))], "number", ruling)
    assert found.answer == Answer.RACED
    assert found.robot.startswith("The race decides. mine: success rate 90.0% with mine")


def test_places_are_told():
    """In the answer of several places."""
    decided = change(about(0.5), about(0.9), p=0.01)
    found = judge(NAMES, [decided], "", ruling_of([decided]), where="over 8 places")
    assert found.robot.startswith("mine helps over 8 places: success rate")


def test_other_measures_do_not_decide():
    """They are in the table."""
    found = told(change(about(0.9), about(0.1), HITS, p=0.001), change(about(0.5, width=0.3), about(0.6)))
    assert found.answer == Answer.CANNOT_TELL


def test_no_difference():
    """Both measures lie within their margins, by the tests that say so."""
    success, time = change([1.0] * 20, [1.0] * 20), change(about(7.0, 20), about(7.1, 20), TIME)
    found = told(success, time)
    assert (found.answer, found.decided_by, found.seeds_to_decide) == (Answer.NO_DIFFERENCE, None, None)
    assert found.robot == (
        "mine makes no difference that counts: success rate 100.0% with mine, 100.0% with base (difference -2.8 to "
        "+2.8 points), less than 5 points of success apart; time to target 7.1 steps with mine, 7 steps with base "
        "(difference +0.1 to +0.1 steps), less than 10% of the time apart (equivalence by two one-sided tests, 5% "
        "each). No seed failed. But 20 seeds cannot rule out that up to 15% of all trainings fail under either reward."
    )


def test_no_difference_in_one_measure_is_none_in_all():
    """Success alike and the time unknown: cannot tell."""
    time = change(about(7.0, 20, 3.0), about(7.0, 20)[::-1], TIME)
    assert told(change([1.0] * 20, [1.0] * 20), time).answer == Answer.CANNOT_TELL


def test_clear_difference_below_the_margin_is_a_difference():
    """A test that shows one goes before a margin."""
    assert told(change([1.0] * 20, [0.99] * 20, p=0.001)).answer == Answer.HURTS


@pytest.mark.parametrize(("measure", "baseline", "margin"), [(SUCCESS, 0.5, 0.05), (TIME, 8.0, 0.8), (TIME, 0.0, 0.0)])
def test_margins(measure: Measure, baseline: float, margin: float):
    """5 points of success, a tenth of the baseline's time."""
    assert margin_of(change([baseline] * 3, [1.0] * 3, measure)) == pytest.approx(margin)


def test_cannot_tell_says_how_many_seeds_would():
    """For the difference that was seen."""
    success = change(about(0.5, width=0.1), about(0.52, width=0.2), p=0.4)
    found = told(success, asked=28)
    seen = seeds_to_tell(0.02, (success.variance / 2) ** 0.5, SEEDS, 28, 0.05)
    assert (found.answer, found.seeds_to_decide) == (Answer.CANNOT_TELL, seen)
    assert found.robot == (
        "Cannot tell from 10 seeds whether mine helps or hurts: success rate 52.0% with mine, 50.0% with base "
        "(difference -5.4 to +9.4 points). The difference is at most 8.0 points of success (90% interval). "
        f"{seen[0]} to {seen[1]} seeds would tell the difference that was seen."
    )


def test_a_number_of_seeds_that_nobody_knows_is_no_plan():
    """Above a factor of ten between its ends; `seeds_to_decide` keeps the range."""
    few = told(change([0.5, 0.7, 0.52], [0.58, 0.66, 0.71], p=0.7), asked=28)
    low, high = few.seeds_to_decide
    assert high > 10 * low
    assert few.robot.endswith("3 seeds are too few to plan how many would tell the difference that was seen.")


def test_the_same_steps_need_no_test():
    """Three seeds are no statistics, but what is equal bit for bit is no difference; nobody who fails is told so."""
    equal = [change([1.0] * 3, [1.0] * 3)]
    found = judge(NAMES, equal, "number", same_steps=True)
    assert (found.answer, found.decided_by) == (Answer.NO_DIFFERENCE, None)
    assert found.robot.startswith("mine changes nothing: with 3 seeds, every step of every evaluation is the same as")
    assert judge(NAMES, equal, "number").answer == Answer.CANNOT_TELL
    lost = [change([0.0] * 3, [0.0] * 3)]
    assert judge(NAMES, lost, "number", same_steps=True).answer == Answer.NEITHER_LEARNS


def test_an_interval_without_zero_that_is_no_answer_is_explained():
    """In two plain sentences, with how many questions were asked."""
    found = told(change(about(0.5), about(0.9), p=0.2), asked=8)
    assert "The interval of success leaves out 0 when it is looked at alone. But 8 questions were asked" in found.robot
    assert "8 questions were asked together, and allowing for all of them p is 0.200." in found.robot
    alone = told(change(about(0.5), about(0.9), p=0.2))
    assert "when it is looked at alone. But the test allows for all deciding measures, and its p is 0.200." in (
        alone.robot
    )


def test_seeds_that_would_tell_are_for_both_measures():
    """The one that takes more decides; the high end is more than there are."""
    success = change(about(0.5), about(0.5))
    time = change(about(7.0, width=2.0), about(7.0, width=2.0)[::-1], TIME)
    found = told(success, time)
    expected = seeds_to_tell(0.7, (time.variance / 2) ** 0.5, SEEDS, 1, 0.05)
    assert (
        f" to {expected[1]} seeds would tell a difference of 5 points of success or of 10% of the time." in found.robot
    )
    few = told(change([1.0] * 8, [0.98] * 8))
    assert few.seeds_to_decide is None or few.seeds_to_decide[1] > 8


@pytest.mark.parametrize(("seeds", "said"), [(1, "1 seed"), (2, "2 seeds"), (3, "3 seeds")])
def test_few_seeds_cannot_tell(seeds: int, said: str):
    """However far apart: the smallest p-value of so many is above 0.05."""
    found = told(change([0.1] * seeds, [0.9] * seeds))
    assert found.answer == Answer.CANNOT_TELL
    assert found.robot.startswith(
        f"Cannot tell from {said} whether mine helps or hurts: success rate 90.0% with mine, 10.0% with base"
    )


def test_one_seed_names_the_fewest_that_can_show_something():
    """No interval, and no number of seeds from the spread of one."""
    found = told(change([0.1], [0.9], p=None))
    assert found.seeds_to_decide is None
    assert found.robot.endswith("10.0% with base. Fewer than 4 seeds cannot show anything here.")


def test_spread_that_takes_thousands_of_seeds_is_told():
    """Seeds that go either way all the way: a number that nobody runs is an answer, too."""
    found = told(change([0.0, 1.0] * 5, [1.0, 0.0] * 5))
    assert found.seeds_to_decide is not None
    assert min(found.seeds_to_decide) > 1_000


@pytest.mark.parametrize(
    "changes", [[], [change(about(0.5), about(0.9), HITS)], [change_of(SUCCESS, {0: None}, {0: 0.5}, swaps_of([0]))]]
)
def test_behaviour_that_was_not_measured(changes: list[Change]):
    """Without a success rate or a time under both rewards there is nothing to rest on."""
    found = headline_of(NAMES, compared(), changes)
    assert (found.answer, found.robot) == (Answer.CANNOT_TELL, UNMEASURED)


def test_time_alone_can_decide():
    """Where no success rate is there."""
    assert told(change(about(7.0), about(5.0), TIME, p=0.01)).answer == Answer.HELPS
    assert told(change(about(7.0, 20), about(7.0, 20), TIME)).answer == Answer.NO_DIFFERENCE


@given(
    st.lists(st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)), min_size=1, max_size=8),
    st.none() | st.floats(0.0, 1.0),
    st.sampled_from([SUCCESS, TIME]),
)
def test_no_claim_without_a_corrected_p_value(pairs: list[tuple[float, float]], p: float | None, measure: Measure):
    """No word of better or worse, helps or hurts, stands where p is above 0.05 or is not known."""
    one, other = (list(values) for values in zip(*pairs, strict=True))
    found = told(change(one, other, measure, p))
    sentences = found.robot.replace("whether mine helps or hurts", "")
    if p is None or p > 0.05:
        assert found.answer in (Answer.CANNOT_TELL, Answer.NO_DIFFERENCE, Answer.NEITHER_LEARNS)
        assert not CLAIM.search(sentences + found.number)
    assert (found.answer in (Answer.HELPS, Answer.HURTS)) == bool(CLAIM.search(sentences))


# The number


def number(found: Decomposition, name: str = "I_P") -> str:
    """What is said of one index."""
    said = headline_of(NAMES, found).number
    return said[said.index(name) :]


# The trial that all of this is for: 10 runs each, K2 = 1.5
TRIAL = {"bb": (-1000.0, 1000.0), "bk": (-1430.0, 500.0), "kb": (-60.0, 46_500.0), "kk": (-90.0, 25_600.0)}


def test_triumph_that_is_all_ruler():
    """eta_P of 25.6: 48.8 is the ruler's, and the runs are worth half. No word of better stands there."""
    assert number(compared(**TRIAL)) == (
        "I_P with mine is 25.6 times that with base: x 48.8 from counting the same runs differently (ruler), "
        "x 0.525 from different runs (behaviour)."
    )


def test_both_indices_are_told():
    """I_N first."""
    said = headline_of(NAMES, compared(**TRIAL)).number
    assert said.startswith("I_N with mine is 0.09 times that with base: x 0.0615 from ")
    assert said.index("I_N with mine") < said.index("I_P with mine")


def test_intervals_stand_behind_their_values():
    """Where there are enough seeds."""
    assert number(compared(kb=(-50.0, 200.0), kk=(-50.0, 200.0), seeds=3)) == (
        "I_P with mine is 2 [2, 2] times that with base: x 2 [2, 2] from counting the same runs differently "
        "(ruler), x 1 [1, 1] from different runs (behaviour)."
    )


def test_index_that_says_little():
    """The reason, without a number."""
    assert number(compared(kb=(-100.0, 4000.0), kk=(-100.0, 1.0)), "eta_P") == (
        "eta_P says little: I_P of the proposed reward is near zero beside that of the baseline runs under the "
        "proposed reward."
    )


def test_index_that_is_not_defined():
    """The reason behind n/a."""
    assert number(compared(bb=(-100.0, 0.0)), "eta_P") == (
        "eta_P n/a: I_P of the baseline is 0: its mean accumulated reward is never positive."
    )


def test_part_near_zero_is_not_split():
    """Eta stands; the path's index says why it is not split."""
    assert number(compared(bk=(-100.0, 0.5))) == (
        "I_P with mine is 1 times that with base; not split: I_P of the proposed runs under the baseline reward is "
        "near zero beside that of the baseline."
    )


def test_eta_that_was_not_scored_again():
    """What is missing."""
    alone = decompose(
        {BB: group(SAME, 2), KK: group((-100.0, 200.0), 2)}, missing="base.csv has no distances to score again"
    )
    assert number(alone) == (
        "I_P with mine is 2 times that with base; not split: base.csv has no distances to score again."
    )


def test_behaviour_that_depends_on_the_judge_is_flagged():
    """At the end, with the index's name; it is no claim about the robot."""
    opposed = compared(bk=(-100.0, 200.0), kb=(-100.0, 400.0), kk=(-100.0, 200.0))
    said = number(opposed)
    assert said.endswith(
        " eta_P: the behaviour depends on who judges it: x 2 under the baseline reward, x 0.5 under the proposed one."
    )
    assert not CLAIM.search(said)


@pytest.mark.parametrize("seeds", [1, 2, 4])
def test_headline_is_whole_sentences(seeds: int):
    """Whatever the notes are."""
    found = headline_of(NAMES, compared(**TRIAL, seeds=seeds), [change(about(0.5, seeds), about(0.4, seeds))])
    for said in (found.robot, found.number):
        assert said.endswith(".")
        assert not re.search(r"\n|\.\.|  |None|nan", said)


def test_json_is_plain():
    """Both answers."""
    found = told(change(about(0.5, width=0.1), about(0.52, width=0.2)), asked=28)
    data = json.loads(json.dumps(found.to_json()))
    assert set(data) == {"answer", "behaviour", "number", "decided_by", "seeds_to_decide"}
    assert (data["answer"], data["seeds_to_decide"]) == ("cannot tell", list(found.seeds_to_decide))


# Measures of any env


def test_any_measure_decides_by_its_own_name():
    """A share is told in percent and points, another measure in its unit, one without a unit as a number."""
    share = Measure("has_landed", "", "higher", "in evaluations", 100)
    height = Measure("end_height", "", "higher", "in evaluations")
    better = change(about(0.5), about(0.9), share, p=0.01)
    decided = judge(NAMES, [better], "number", ruling_of([better]))
    assert decided.robot.startswith("mine helps: has landed 90.0% with mine, 50.0% with base (difference +")
    assert "points); 10 seeds" in decided.robot
    open_ = judge(NAMES, [change(about(5.0, width=3.0), about(6.0, width=-3.0), height)], "number")
    assert "end height 6 with mine, 5 with base (difference -" in open_.robot
    assert open_.robot.endswith("would tell the difference that was seen.")
    same = judge(NAMES, [change(about(5.0, width=3.0), about(5.0, width=-3.0), height)], "number")
    assert same.robot.endswith("would tell a difference of 10% of end height.")


def test_without_a_measure_the_reason_is_told():
    """As it was given."""
    assert judge(NAMES, [], "number", unmeasured="Nobody looked.").robot == "Nobody looked."
