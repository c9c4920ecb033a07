"""The questions of an experiment, and their answers beside each comparison."""

from dataclasses import replace

import numpy as np
import pytest

from harness.record import Terms
from harness.results.compare import with_verdicts
from harness.results.comparison import Behaviour, StepChange, still_to_come
from tests.results.told import SUCCESS, change, comparison, rates

PLACES = ("mujoco", "pybullet", "drake", "physx")


def of_success(proposed, mean, place="mujoco", seed=0, seeds=20):
    """A comparison with a baseline that succeeds in half of the episodes."""
    return comparison(proposed, {"success_rate": rates(0.5, mean, seeds, seed=seed)}, place)


def changed(found, *changes, **fields):
    """The comparison with other measures."""
    return replace(found, measured=replace(found.measured, changes=changes, **fields))


def test_the_order_of_the_comparisons_stays():
    """Whatever is asked together."""
    asked = [of_success(name, 0.5, place) for name in ("dense", "arp") for place in PLACES[:2]]
    assert [(it.group, it.proposed) for it in with_verdicts(asked)] == [(it.group, it.proposed) for it in asked]


def test_rewards_in_one_place_are_asked_together():
    """Each has a larger p than alone."""
    both = with_verdicts([of_success("dense", 0.6), of_success("arp", 0.6, seed=1)])
    (alone,) = with_verdicts([of_success("dense", 0.6)])
    assert [it.answer.ruling.asked for it in both] == [2, 2]
    assert both[0].answer.ruling.corrected >= alone.answer.ruling.corrected


def test_several_places_get_one_answer():
    """The same in each comparison; four small differences add up."""
    found = with_verdicts([of_success("dense", 0.58, place, seed) for seed, place in enumerate(PLACES)])
    assert len({id(it.answer.pool) for it in found}) == 1
    pool = found[0].answer.pool
    assert pool.headline.answer == "helps"
    assert pool.places == tuple(it.group.title for it in found)


def test_places_of_other_budgets_are_other_questions():
    """What holds after 1,000 steps may not hold after 2,000."""
    short, long = of_success("dense", 0.9), of_success("dense", 0.9, seed=1)
    long = replace(long, group=long.group._replace(steps=2000))
    found = with_verdicts([short, long])
    assert [it.answer.pool for it in found] == [None, None]
    assert [it.answer.ruling.asked for it in found] == [2, 2]


def test_a_null_control_is_no_question():
    """It takes nothing from the rewards, and is ruled by itself."""
    control = comparison("baseline", {"success_rate": rates(0.5, 0.5)})
    alone, beside = with_verdicts([of_success("dense", 0.9)])[0], with_verdicts([of_success("dense", 0.9), control])[0]
    assert alone.answer.ruling == beside.answer.ruling


def test_a_comparison_without_values_is_no_question():
    """It has no ruling that decides, and takes nothing from the others."""
    found = with_verdicts([of_success("dense", 0.9), changed(of_success("arp", 0.5))])
    assert found[0].answer.ruling.asked == 1
    assert not found[1].answer.ruling.is_decided


def test_places_with_other_units_are_put_together_relative_to_the_baseline():
    """As numbers they could not be."""
    times = {"time_to_target": 1.0 + rates(0.9, 0.1)}
    one = comparison("dense", times, "mujoco")
    other = comparison("dense", {"time_to_target": 1000.0 * times["time_to_target"]}, "pybullet")
    ((first,), (second,)) = (it.measured.changes for it in (one, other))
    other = changed(other, replace(second, measure=second.measure._replace(unit="ms")))
    pool = with_verdicts([one, other])[0].answer.pool
    (measure,) = pool.measures
    assert measure.is_relative
    assert measure.difference == pytest.approx(first.proposed / first.baseline - 1.0)
    assert pool.headline.answer == "helps"


def test_a_place_is_not_told_while_the_answer_over_all_places_is_open():
    """However clear it looks: no number of trainings there is a plan, and the reason is not how many were asked."""
    up = comparison("dense", {"success_rate": rates(0.4, 0.8, seeds=20)}, "mujoco")
    down = comparison("dense", {"success_rate": rates(0.8, 0.4, seeds=20, seed=1)}, "pybullet")
    found, _ = with_verdicts([up, down])
    assert found.answer.ruling.is_held
    assert found.headline.answer == "cannot tell"
    assert found.headline.seeds_to_decide is None
    assert found.headline.robot.endswith(" A single place is told only where the answer over all is.")
    assert found.answer.pool.headline.seeds_to_decide is not None
    assert "in each place would show it" in found.answer.pool.headline.robot


def test_a_place_of_a_decided_answer_says_what_would_tell():
    """There trainings of its own are a help."""
    better = comparison("dense", {"success_rate": rates(0.4, 0.9)}, "mujoco")
    same = comparison("dense", {"success_rate": rates(0.5, 0.51, seed=1)}, "pybullet")
    _, found = with_verdicts([better, same])
    assert not found.answer.ruling.is_held
    assert found.headline.seeds_to_decide is not None


def test_what_does_not_decide_is_a_hint():
    """It has a p of a family of its own, and decides nothing."""
    (found,) = with_verdicts(
        [comparison("dense", {"success_rate": rates(0.5, 0.5), "time_to_target": rates(0.5, 0.5)})]
    )
    assert found.answer.claims == 0
    with_hint = replace(found, measured=replace(found.measured, deciding=("success_rate",)))
    (found,) = with_verdicts([with_hint])
    assert found.answer.claims == 1


def test_success_over_the_training_that_decides_anyway_counts_once():
    """Recordings without evaluations have nothing else."""
    found = comparison("dense", {"success_rate": rates(0.5, 0.9)}, speed=rates(0.3, 0.8))
    found = changed(found, *found.measured.changes[1:], decided_in="while training")
    assert found.decisive_changes == found.measured.changes


def test_a_measure_without_a_value_in_some_training_does_not_decide():
    """Those that have one are a selection."""
    found = comparison("dense", {"success_rate": rates(0.5, 0.5), "time_to_target": 3.0 + rates(0.9, 0.1)})
    success, time = found.measured.changes
    short = replace(time, measure=time.measure._replace(bounds=(0.0, np.inf)), lost=((), (20,)))
    (both,) = with_verdicts([changed(found, success, short)])
    assert len(both.answer.ruling.of_measures) == 1
    (alone,) = with_verdicts([changed(found, short, deciding=("time_to_target",))])
    assert alone.headline.answer == "cannot tell"
    assert "has no value in 1 of 21 trainings with dense" in alone.headline.robot


def test_before_all_trainings_of_a_plan_ended_nothing_is_tested():
    """Whoever looks on and on would find something."""
    found = with_verdicts([of_success("dense", 0.9, place) for place in PLACES[:2]], to_come=2)
    assert [(it.answer.ruling.p, it.answer.ruling.missing, it.headline.answer) for it in found] == [
        (None, "2 trainings are missing", "interim")
    ] * 2
    assert found[0].answer.pool.headline.answer == "interim"


def test_a_training_without_a_value_counts_where_it_is_known_how_bad_it_can_be():
    """As one that took the whole time."""
    found = comparison("dense", {"time_to_target": 3.0 + rates(0.9, 0.1)})
    (time,) = found.measured.changes
    lost = replace(time, lost=((), (20, 21, 22, 23)))
    whole, some = (with_verdicts([changed(found, it, deciding=("time_to_target",))])[0] for it in (time, lost))
    assert (whole.headline.answer, some.headline.answer) == ("helps", "ahead so far")
    assert some.decisive.low < whole.decisive.low


def test_looks_tell_which_seeds_count():
    """Seeds of a look that is not complete change nothing."""
    asked = of_success("dense", 0.5, seeds=8)
    terms = Terms((4, 8), margin=0.001)

    def ruled(it, complete):
        return with_verdicts([it], terms, lambda it: ({s: int(s >= 4) for s in it.seeds}, complete))[0].answer.ruling

    few = np.array([it[:4] for it in asked.measured.changes[0].values])
    assert ruled(asked, 1) == ruled(comparison("dense", {"success_rate": few}), 1)
    assert ruled(asked, 1) != ruled(asked, 2)


def test_hints_of_an_unfinished_plan_say_no_word():
    """They keep their p, which whoever looks on may read; nothing is called better or worse."""
    it = of_success("dense", 0.9)
    (decides,) = it.measured.changes
    hint = change(SUCCESS._replace(manner="stochastic"), rates(0.5, 0.9), range(20))
    hinted = changed(it, decides, hint, along=(StepChange(500, (decides,)),))
    (ended,), (interim,) = with_verdicts([hinted]), with_verdicts([hinted], to_come=1)
    assert [found.measured.changes[-1].direction for found in (ended, interim)] == ["better", ""]
    assert ended.measured.changes[-1].corrected == interim.measured.changes[-1].corrected
    assert [found.measured.along[0].answer for found in (ended, interim)] == ["better", "cannot tell"]
    assert (interim.decisive.p, interim.decisive.corrected) == (None, None)


def test_a_plan_of_looks_is_never_unfinished():
    """It says itself when to look; what is not needed any more would be pending for ever."""
    unmeasured = replace(of_success("arp", 0.5), measured=Behaviour())
    terms = Terms((3, 6), asked=2, margin=0.1)
    look_of = lambda it: ({seed: int(seed >= 3) for seed in range(6)}, 2)  # noqa: E731
    found = with_verdicts([of_success("dense", 0.9), unmeasured], terms, look_of, to_come=9)
    assert still_to_come(found) == ""


def test_a_measure_that_one_place_lacks_decides_in_none():
    """So the answer of a place speaks of the measures that the test was asked about, and of no other."""
    both = {"success_rate": rates(0.5, 0.9), "time_to_target": 3.0 + rates(0.9, 0.1)}
    found = with_verdicts(
        [comparison("dense", both, speed=rates(0.3, 0.6)), of_success("dense", 0.9, "pybullet", seed=1)]
    )
    assert [it.name for it in found[0].answer.pool.measures] == ["success_rate"]
    assert [[(it.name, it.measure.manner) for it in one.decisive_changes] for one in found] == [
        [("success_rate", "deterministic")]
    ] * 2
    assert [it.headline.answer for it in found] == ["helps", "helps"]
