"""What it does to the promise to add rewards or seeds later, to stop early, or to begin anew: the table of the docs.

Nothing does anything in these experiments, so every answer is false. ``pytest -m slow -s`` prints the table.
"""

import numpy as np
import pytest

from harness.eta import Question, rule
from harness.eta.verdict.ruling import LEVEL
from tests.eta.scenarios import error, is_kept

EXPERIMENTS = 1000


def answers(values: np.ndarray) -> bool:
    """Whether a report of these rewards, (rewards, seeds), the baseline first, says anything."""
    questions = [Question.of(np.stack([values[0], it])[:, :, None, None]) for it in values[1:]]
    return any(it.is_decided for it in rule(questions))


@pytest.mark.slow
def test_rewards_that_are_added_later():
    """The last report keeps its word. Whoever counts each report on the way has 2 points more."""
    rng, last, ever = np.random.default_rng(1), 0, 0
    for _ in range(EXPERIMENTS):
        values = rng.normal(size=(5, 10))
        reports = [answers(values[: 2 + count]) for count in range(4)]
        last, ever = last + reports[-1], ever + any(reports)
    assert is_kept("four rewards, added one by one: the last report", last / EXPERIMENTS, LEVEL, EXPERIMENTS)
    assert is_kept("any report on the way", ever / EXPERIMENTS, 0.09, EXPERIMENTS)


@pytest.mark.slow
def test_a_new_folder_for_each_reward():
    """Each keeps its word for itself; together they do not."""
    rng, ever = np.random.default_rng(2), 0
    for _ in range(EXPERIMENTS):
        values = rng.normal(size=(5, 10))
        ever += any(answers(values[[0, at]]) for at in range(1, 5))
    assert is_kept("four folders with a reward each", ever / EXPERIMENTS, 0.17, EXPERIMENTS)
    assert ever / EXPERIMENTS > LEVEL + error(LEVEL, EXPERIMENTS)


@pytest.mark.slow
def test_seeds_that_are_added_when_the_answer_did_not_come():
    """6, then 10, then 16: what a page warns of."""
    rng, ever = np.random.default_rng(3), 0
    for _ in range(EXPERIMENTS):
        values = rng.normal(size=(2, 16))
        ever += any(answers(values[:, :seeds]) for seeds in (6, 10, 16))
    assert is_kept("seeds added twice", ever / EXPERIMENTS, 0.11, EXPERIMENTS)


@pytest.mark.slow
def test_a_new_folder_when_the_answer_did_not_come():
    """Three times the same study, the best told."""
    rng, ever = np.random.default_rng(4), 0
    for _ in range(EXPERIMENTS):
        ever += any(answers(rng.normal(size=(2, 10))) for _ in range(3))
    assert is_kept("three folders of the same study", ever / EXPERIMENTS, 1.0 - (1.0 - LEVEL) ** 3, EXPERIMENTS)
    assert ever / EXPERIMENTS > LEVEL + error(LEVEL, EXPERIMENTS)
