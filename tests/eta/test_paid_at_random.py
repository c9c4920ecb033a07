"""Whether a reward pays random actions more than the policies that it trained, and how often that is said wrongly."""

import numpy as np
import pytest
from numpy.random import default_rng

from harness.eta.headline import paid_at_random

DRAWS = 2_000
SPARE = 0.016
"""Three standard errors of a share of 0.05 in so many draws, and a little."""


def _found(trained, episodes):
    found = paid_at_random("hop", trained, np.array(episodes, np.float64))
    assert found is not None
    return found


def test_six_trainings_below_are_enough():
    """A coin falls so once in 64 times."""
    found = _found([1.0] * 6, [2.0, 3.0] * 50)
    assert (found.below, found.p, found.is_below) == (6, 1 / 64, True)


@pytest.mark.parametrize("trained", [[1.0] * 4, [1.0] * 5 + [9.0], [9.0] * 6])
def test_otherwise_nothing_is_claimed(trained):
    """Too few trainings, or one that learned, or all of them."""
    found = _found(trained, [2.0, 3.0] * 50)
    assert not found.is_below
    assert found.told == ""


def test_random_actions_count_by_their_lower_bound():
    """That few episodes were lucky is no shame of the policies."""
    assert _found([2.0] * 6, [1.9, 2.4] * 2).is_below is False
    assert _found([2.0] * 6, [1.9, 2.4] * 50).is_below is True


def test_rounding_is_no_difference():
    """A reward that pays everything the same is not said to have been missed."""
    constant = 0.1 * 3
    assert not _found([0.1 + 0.1 + 0.1 - 1e-16] * 6, [constant] * 100).is_below


@pytest.mark.parametrize(("trained", "episodes"), [([], [1.0, 2.0]), ([1.0], [2.0]), ([1.0], [])])
def test_without_trainings_or_episodes_nothing_is_known(trained, episodes):
    """A mean of one episode has no bound."""
    assert paid_at_random("hop", trained, np.array(episodes, np.float64)) is None


def test_the_sentence_has_both_means():
    """And says what cannot be concluded."""
    told = _found([-1400.0] * 7 + [0.0], [-1200.0, -1201.0] * 50).told
    assert told.startswith("hop was not maximised: it pays random actions more than the policies of 7 of 8 trainings")
    assert "(-1,200 an episode; after training -1,225 on average)" in told.replace("-1,200.5", "-1,200")
    assert "this comparison says nothing about what hop asks for" in told


def test_json_is_plain():
    """All that the claim follows from, but for the episodes."""
    assert _found([1.0] * 6, [2.0, 3.0] * 50).to_json() == {
        "reward": "hop",
        "trained": [1.0] * 6,
        "random": 2.5,
        "below": 6,
        "p": 1 / 64,
    }


def _bell(rng, count):
    return rng.normal(0.0, 1.0, count)


def _rarely_learns(rng, count):
    """Half of the trainings fail, the others learn: as likely above as below what random actions are paid."""
    return np.where(rng.random(count) < 0.5, -0.01, 100.0)


def _skewed(rng, count):
    """A median of 0, and a long tail."""
    return np.exp(rng.normal(0.0, 2.0, count)) - 1.0


def _wrong(draw, seeds, spread):
    """How often the claim is made where a training is as likely paid more than random actions as less."""
    rng = default_rng(seeds)
    found = [_found(draw(rng, seeds).tolist(), rng.normal(0.0, spread, 100).tolist()) for _ in range(DRAWS)]
    return float(np.mean([it.is_below for it in found]))


def test_a_wrong_claim_is_made_in_few_cases(subtests):
    """In at most `LEVEL` of the experiments, whether the episodes of random actions are alike or not."""
    for spread in [0.01, 3.0]:
        for draw in [_bell, _rarely_learns, _skewed]:
            for seeds in [5, 6, 8, 16]:
                with subtests.test(spread=spread, draw=draw, seeds=seeds):
                    assert _wrong(draw, seeds, spread) <= 0.05 + SPARE


def test_a_looser_level_is_noticed(monkeypatch):
    """By the same simulation."""
    monkeypatch.setattr("harness.eta.headline.LEVEL", 0.12)
    assert _wrong(_bell, 6, 0.01) > 0.05 + SPARE


def test_a_clear_case_is_seen():
    """Policies that are paid two standard deviations less are found out nearly always."""
    rng = default_rng(0)
    seen = [_found(rng.normal(-2.0, 0.5, 6).tolist(), rng.normal(0.0, 3.0, 100).tolist()).is_below for _ in range(400)]
    assert np.mean(seen) > 0.9
