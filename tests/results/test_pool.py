"""One answer about a reward over all places in which it trained."""

import json
from dataclasses import replace

from harness.eta import Answer, Ruling
from harness.results.compare import with_verdicts
from harness.results.pool import Pool
from tests.results.told import comparison, rates

PLACES = ("mujoco", "pybullet", "drake", "physx")


def pool_of(mean, spread=0.05):
    """Of a reward with this success in four places, beside a baseline with 0.5."""
    found = with_verdicts(
        [
            comparison("dense", {"success_rate": rates(0.5, mean, seed=seed, spread=spread)}, place)
            for seed, place in enumerate(PLACES)
        ]
    )
    pool = found[0].answer.pool
    assert pool is not None
    return pool


def test_the_answer_says_over_how_many_places_and_in_how_many_at_least():
    """In one sentence each."""
    told = pool_of(0.9).headline.robot
    assert told.startswith("Success +40.6 points on average over 4 places (+")
    assert " dense helps over 4 places. One training more of either reward" in told
    assert told.endswith("It is better in all 4 places.")


def test_a_reward_that_hurts_is_worse():
    """The sentence follows the answer."""
    told = pool_of(0.1).headline
    assert told.answer == "hurts"
    assert "It is worse in all 4 places." in told.robot


def test_what_is_not_decided_says_no_place():
    """But how many trainings would show that nothing differs."""
    told = pool_of(0.5, spread=0.2).headline
    assert told.answer == "cannot tell"
    assert told.robot.endswith(" trainings of each reward in each place would show it.")
    assert "at least" not in told.robot


def test_where_no_place_is_sure_it_says_so():
    """The mean over all of them passes, no set of places without others does."""
    pool = pool_of(0.9)
    told = Pool(pool.names, pool.steps, pool.places, pool.ruling, pool.measures, 0).headline.robot
    assert told.endswith(
        "In which of the 4 places it is better is not decided; it is worse in none by more than chance."
    )


def test_places_that_go_the_other_way_make_it_mixed():
    """Both numbers are told, on the first screen too; where all are better, another measure is worse."""
    pool = pool_of(0.9)
    some = replace(pool, better_in=3, opposed_in=1)
    assert some.headline.answer == Answer.MIXED
    for told in (some.headline.robot, some.lead):
        assert told.endswith("It is better in at least 3 of 4 places; it is worse in at least 1.")
    every = replace(pool, opposed_in=1)
    assert every.headline.robot.endswith("It is better in all 4 places; by another measure it is worse in at least 1.")
    assert replace(some, measures=()).headline.answer == Answer.MIXED


def test_trainings_that_are_still_to_come_are_told():
    """Whether there are values or not."""
    pool = replace(pool_of(0.9), ruling=Ruling(missing="8 trainings are missing"), better_in=0)
    assert pool.headline.answer == replace(pool, measures=()).headline.answer == Answer.INTERIM
    assert "at least" not in pool.headline.robot


def test_without_measures_in_one_unit_there_is_an_answer_but_no_value():
    """The test is relative to the size of each."""
    pool = pool_of(0.9)
    told = Pool(pool.names, pool.steps, pool.places, pool.ruling, (), 2).headline
    assert told.robot == (
        "dense helps over 4 places. It is better in at least 2 of 4 places; it is worse in none by more than chance."
    )
    open_ = Pool(pool.names, pool.steps, pool.places, Ruling(), ()).headline
    assert open_.robot == "Cannot tell over 4 places: each place measures something else."


def test_a_pool_is_plain_data():
    """With its test and its measures."""
    told = json.loads(json.dumps(pool_of(0.9).to_json()))
    assert told["answer"] == "helps"
    assert told["better_in"] == 4
    assert told["test"]["is_decided"]
    assert [(it["name"], it["p_corrected"]) for it in told["measures"]] == [
        ("success_rate", told["test"]["p_corrected"])
    ]


def test_a_place_says_what_holds_over_all():
    """Where it cannot be told by itself."""
    found = with_verdicts(
        [
            comparison("dense", {"success_rate": rates(0.5, mean, seed=seed)}, place)
            for seed, (place, mean) in enumerate(zip(PLACES, (0.9, 0.9, 0.9, 0.5), strict=True))
        ]
    )
    told = found[3].headline.robot
    assert told.startswith("Over 4 places together: HELPS. Of this place alone: Success ")
