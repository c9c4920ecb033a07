"""How fast recorded runs are scored again."""

import numpy as np
import pytest
from numpy.random import default_rng

from harness import load_registry
from harness.log import trace_of
from harness.registry import choose
from harness.reward.row_steps import DISTANCES, part_of
from harness.score.scorer import BLOCK, Scorer, pay_log

pytestmark = [
    pytest.mark.bench,
    pytest.mark.parametrize("name", ["baseline", "arp"]),
]
EPISODE = 101
AT_LEAST = 0.15
"""Of the speed of the formula alone; 0.22 to 0.32 was measured, some 100 million rows per second."""


@pytest.fixture(scope="module", name="rows")
def _rows(amount):
    """A long run: episodes of 100 steps after their start row, distances that go up and down."""
    episodes = default_rng(0).uniform(0.0, 1.0, (amount(4_000_000, 2 * BLOCK) // EPISODE, EPISODE))
    begin = np.repeat(episodes[:, :1], EPISODE, axis=1)
    best = np.minimum.accumulate(episodes, axis=1)
    best = np.concatenate([begin[:, :1], best[:, :-1]], axis=1)
    start = np.zeros(episodes.shape, bool)
    start[:, 0] = True
    columns = (start, begin, best, episodes, np.zeros_like(start))
    names = ("start", *DISTANCES, "touched")
    return {name: np.ascontiguousarray(column.ravel()) for name, column in zip(names, columns, strict=True)}


@pytest.fixture
def pieces(rows):
    """The same run in blocks, as files are read."""
    return [part_of(rows, slice(first, first + BLOCK)) for first in range(0, len(rows["start"]), BLOCK)]


@pytest.fixture
def reward(name):
    """By its name."""
    registry = load_registry()
    return choose(registry, "rewards", name).build(registry, "rewards")


@pytest.fixture
def score_bare(pieces):
    """The formula alone on all rows, in numpy, block by block: it reads the same columns and writes the same one."""

    def score():
        for rows in pieces:
            lost = rows["distance"] - rows["previous_best"]
            np.where(rows["start"], 0.0, np.where(lost > 0.0, -lost, rows["begin_distance"] - rows["distance"]))

    return score


def require_paid(paid, rows):
    """Every row is scored; its start rows are paid nothing, and nearly all others something."""
    assert paid.shape == rows["start"].shape
    assert (paid[rows["start"]] == 0.0).all()
    assert (paid[~rows["start"]] != 0.0).mean() > 0.9


def test_pieces_beside_the_formula(require_speed, score_bare, rows, pieces, reward):
    """One core, pieces of 65,536 rows, as files are read."""

    def score():
        scorer = Scorer(reward)
        return [scorer.pay(piece).total for piece in pieces]

    require_speed(score_bare, score, AT_LEAST)
    require_paid(np.concatenate(score()), rows)


def test_whole_runs_beside_the_formula(require_speed, score_bare, rows, reward):
    """One core, all rows at once."""
    require_speed(score_bare, lambda: Scorer(reward).pay(rows), AT_LEAST)
    require_paid(Scorer(reward).pay(rows).total, rows)


def test_traces_beside_the_formula(require_speed, score_bare, rows, reward):
    """One core, a trace in memory, recorded in one env."""
    step = np.tile(np.arange(EPISODE, dtype=np.int32), len(rows["start"]) // EPISODE)
    flags = dict.fromkeys(("reached", "terminated", "truncated"), rows["touched"])
    distances = {name: rows[name] for name in DISTANCES}
    log = trace_of({"env": np.zeros_like(step), "step": step, "reward": rows["distance"], **distances, **flags})
    require_speed(score_bare, lambda: pay_log(reward, log).total, AT_LEAST)
    require_paid(pay_log(reward, log).total, rows)
