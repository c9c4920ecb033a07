"""A race of several rewards for the best one."""

import math

import numpy as np
import pytest
from numpy.random import default_rng

from harness.eta import RACE, race
from harness.eta.verdict.race import spent


def values_of(mean, spread=0.05, places=1, seed=0):
    """Of one candidate, (places, seeds)."""
    return mean + spread * default_rng([seed, int(1000 * abs(mean))]).normal(size=(places, RACE[-1]))


def raced(values, looks=7):
    """How the race stands after so many looks."""
    return race(values, RACE, dict.fromkeys(values, looks))


def test_nobody_leaves_before_the_first_look():
    """And nobody wins."""
    found = raced({"good": values_of(0.9), "bad": values_of(0.1)}, 0)
    assert (found.looks, found.beaten, found.is_over) == (0, {}, False)


def test_who_is_beaten_leaves_and_the_last_one_is_the_best():
    """With the look, and by whom; as plain data."""
    assert raced({"bad": values_of(0.1), "good": values_of(0.9)}).to_json() == {
        "looks": 1,
        "living": ["good"],
        "beaten": {"bad": {"look": 0, "by": "good"}},
        "best": "good",
        "is_close": False,
        "is_over": True,
    }


def test_who_has_left_is_not_asked_for_more_looks():
    """The others go on; a look waits for all who live, so that nobody is judged by fewer seeds than the others."""
    values = {"good": values_of(0.9, 0.2), "close": values_of(0.75, 0.2, seed=1), "bad": values_of(-9.0)}
    found = race(values, RACE, {"good": 3, "close": 3, "bad": 1})
    assert (found.looks, found.beaten["bad"].look) == (3, 0)
    assert race(values, RACE, {"good": 4, "close": 2, "bad": 1}).looks == 2


def test_rewards_that_are_as_good_end_the_race():
    """Both are within five points of the best."""
    found = raced({"one": values_of(0.9, 0.01), "other": values_of(0.9, 0.01, seed=1)})
    assert found.is_close
    assert found.is_over
    assert found.best is None
    assert set(found.living) == {"one", "other"}


def test_the_looks_can_run_out():
    """Then those that are left can still be the best."""
    found = raced({"one": values_of(0.5, 0.3, seed=1), "other": values_of(0.5, 0.3, seed=2)})
    assert found.is_over
    assert not found.is_close
    assert len(found.living) == 2


def test_a_candidate_whose_trainings_fail_leaves():
    """It has no numbers, and nobody beat it; of two such nobody is left."""
    broken = np.full((1, RACE[-1]), math.nan)
    found = raced({"good": values_of(0.9), "fine": values_of(0.88, seed=1), "broken": broken})
    assert found.beaten["broken"] == (0, "")
    assert "broken" not in found.living
    found = raced({"one": broken, "other": broken})
    assert (found.best, found.living, found.is_over) == (None, (), True)


def test_several_places_count_with_their_mean():
    """A candidate that is best in one and worst in the other is not the best."""
    torn = np.concatenate([values_of(1.0, 0.01), values_of(0.0, 0.01)])
    assert raced({"torn": torn, "steady": values_of(0.8, 0.01, places=2)}).best == "steady"


def test_a_look_spends_with_the_square_of_its_seeds():
    """At the last look all of it, at half of the seeds a quarter."""
    assert [spent(seeds, 32) for seeds in (16, 32)] == pytest.approx([0.0125, 0.05])


def test_who_leaves_makes_the_share_of_the_others_larger():
    """Beside five hopeless ones a candidate leaves that stays beside five close ones."""
    good, worse = values_of(0.8, 0.1), values_of(0.72, 0.1, seed=1)
    close = {f"close {at}": values_of(0.79, 0.1, seed=10 + at) for at in range(5)}
    hopeless = {f"hopeless {at}": values_of(0.0, 0.1, seed=10 + at) for at in range(5)}
    looks = {
        name: raced({"good": good, "worse": worse, **others}).beaten.get("worse", (99, ""))[0]
        for name, others in (("close", close), ("hopeless", hopeless))
    }
    assert looks["hopeless"] <= looks["close"]
