"""One answer about a reward over all places in which it trained."""

import json

from harness.eta.verdict.ruling import Ruling
from harness.results.pool import Pool
from harness.results.verdicts import with_verdicts
from tests.results.told import comparison, rates

PLACES = ("mujoco", "pybullet", "drake", "physx")


def pool_of(mean: float, spread: float = 0.05) -> Pool:
    """Of a reward with this success in four places, beside a baseline with 0.5."""
    found = with_verdicts(
        [
            comparison("dense", {"success_rate": rates(0.5, mean, seed=seed, spread=spread)}, place)
            for seed, place in enumerate(PLACES)
        ]
    )
    pool = found[0].pool
    assert pool is not None
    return pool


def test_the_answer_says_over_how_many_places_and_in_how_many_at_least():
    """In one sentence each."""
    told = pool_of(0.9).headline.robot
    assert told.startswith("dense helps over 4 places: success rate ")
    assert told.endswith("It does better in all 4 places.")


def test_a_reward_that_hurts_does_worse():
    """The sentence follows the answer."""
    told = pool_of(0.1).headline
    assert told.answer == "hurts"
    assert "It does worse in all 4 places." in told.robot


def test_what_is_not_decided_says_no_place():
    """And how large the difference can be at most."""
    told = pool_of(0.5, spread=0.2).headline
    assert told.answer == "cannot tell"
    assert "The difference is at most " in told.robot
    assert "at least" not in told.robot


def test_where_no_place_is_sure_it_says_so():
    """The mean over all of them passes, no set of places without others does."""
    pool = pool_of(0.9)
    told = Pool(pool.names, pool.steps, pool.places, pool.ruling, pool.measures, 0).headline.robot
    assert told.endswith("In which of the places it does better is not decided.")


def test_without_measures_in_one_unit_there_is_an_answer_but_no_value():
    """The test is relative to the size of each."""
    pool = pool_of(0.9)
    told = Pool(pool.names, pool.steps, pool.places, pool.ruling, (), 2).headline
    assert told.robot == "dense helps over 4 places. It does better in at least 2 of the 4 places."
    open_ = Pool(pool.names, pool.steps, pool.places, Ruling(), ()).headline
    assert open_.robot == "Cannot tell over 4 places: their measures have different units."


def test_a_pool_is_plain_data():
    """With its test and its measures."""
    told = json.loads(json.dumps(pool_of(0.9).to_json()))
    assert told["answer"] == "helps"
    assert told["better_in"] == 4
    assert told["test"]["is_decided"]
    assert [it["name"] for it in told["measures"]] == ["success_rate"]


def test_a_place_says_what_holds_over_all():
    """Where it cannot be told by itself."""
    found = with_verdicts(
        [
            comparison("dense", {"success_rate": rates(0.5, mean, seed=seed)}, place)
            for seed, (place, mean) in enumerate(zip(PLACES, (0.9, 0.9, 0.9, 0.5), strict=True))
        ]
    )
    told = found[3].headline.robot
    assert told.startswith("Over 4 places together dense helps. Of this place alone: ")
