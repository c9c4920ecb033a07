"""What it does to the promise to add rewards or seeds later, to stop early, or to begin anew: the table of the docs.

Nothing does anything in these experiments, so every answer is false. ``pytest -m slow -s`` prints the table.
"""

import numpy as np
import pytest
from numpy.random import default_rng

from harness.eta import Question, rule
from tests.eta.scenarios import LEVEL, error, is_kept

EXPERIMENTS = 1000


def answers(values):
    """Whether a report of these rewards, (rewards, seeds), the baseline first, says anything."""
    questions = [Question.of(np.stack([values[0], it])[:, :, None, None]) for it in values[1:]]
    return any(it.is_decided for it in rule(questions))


@pytest.mark.slow
def test_rewards_that_are_added_later():
    """The last report keeps its word. Whoever counts each report on the way has 2 points more."""
    rng, last, ever = default_rng(1), 0, 0
    for _ in range(EXPERIMENTS):
        values = rng.normal(size=(5, 10))
        reports = [answers(values[: 2 + count]) for count in range(4)]
        last, ever = last + reports[-1], ever + any(reports)
    assert is_kept("four rewards, added one by one: the last report", last / EXPERIMENTS, LEVEL, EXPERIMENTS)
    assert is_kept("any report on the way", ever / EXPERIMENTS, 0.09, EXPERIMENTS)


HABITS = {
    "four folders with a reward each": (0.17, 2, (5, 10), lambda values: [values[[0, at]] for at in range(1, 5)]),
    "6 seeds, then 10, then 16, until the answer comes": (
        *(0.11, 3, (2, 16)),
        lambda values: [values[:, :seeds] for seeds in (6, 10, 16)],
    ),
    "three folders of the same study": (1.0 - (1.0 - LEVEL) ** 3, 4, (3, 2, 10), list),
}


@pytest.mark.slow
@pytest.mark.parametrize("habit", HABITS)
def test_what_the_pages_warn_of(habit):
    """Each report keeps its word for itself; together they do not."""
    bound, seed, shape, reports = HABITS[habit]
    rng, ever = default_rng(seed), 0
    for _ in range(EXPERIMENTS):
        ever += any(map(answers, reports(rng.normal(size=shape))))
    assert is_kept(habit, ever / EXPERIMENTS, bound, EXPERIMENTS)
    assert ever / EXPERIMENTS > LEVEL + error(LEVEL, EXPERIMENTS)
