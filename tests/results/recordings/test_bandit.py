"""From an env to a verdict, with actions that are known beforehand: ruler and behaviour come out as they must."""

from itertools import product
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box

import harness
from harness.report import basis_text
from tests.results.recordings.conftest import load_study, paid_in

PULLS, EPISODES, SEEDS = 4, 10, 6
TRAINING, LAST, EVALUATION = "over the training", "in its last fifth", "in evaluations"
FACTOR, BONUS = 3.0, 2.0
"""`scaled` pays FACTOR times as much as the env, `shifted` BONUS more for each pull."""


class Bandit(gymnasium.Env[Any, Any]):
    """An episode has four pulls; each pays its action. Succeeds if the last one is above 1."""

    observation_space = Box(0, 4, (1,), np.float64)
    action_space = Box(0, 4, (1,), np.float64)

    def reset(self, *, seed=None, options=None):
        """The first pull comes."""
        super().reset(seed=seed)
        self.pulls = 0
        return np.zeros(1), {}

    def step(self, action):
        """Pull."""
        self.pulls += 1
        return np.zeros(1), float(action[0]), self.pulls == PULLS, False, {"success": action[0] > 1.0}


def pulled(reward, seed):
    """The action of every episode of a training, four times each."""
    best = {"plain": 1.05, "scaled": 2.0, "shifted": 0.5}[reward]
    return [(best + 0.1 * seed) * (episode + 1) / EPISODES for episode in range(EPISODES)]


def train(folder, reward, seed, evaluated=False):
    """A learner that does not learn."""
    given = {
        "trained_with": reward,
        "rewards": {
            "plain": lambda before, action, after, info: float(action[0]),
            "scaled": lambda before, action, after, info: FACTOR * float(action[0]),
            "shifted": lambda before, action, after, info: float(action[0]) + BONUS,
        },
        "behaviour": {"success": "success"},
        "seed": seed,
    }
    pays = {"plain": lambda paid: paid, "scaled": lambda paid: FACTOR * paid, "shifted": lambda paid: paid + BONUS}
    env = harness.RecordRewards(gymnasium.wrappers.TransformReward(Bandit(), pays[reward]), folder, **given)
    for value in pulled(reward, seed):
        env.reset()
        for _ in range(PULLS):
            env.step(np.array([value]))
    env.close()
    if evaluated:
        final = np.array([pulled(reward, seed)[-1]])
        harness.evaluate_policy(lambda seen: final, Bandit(), folder / "evaluation", episodes=3, **given)


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """Three rewards, six seeds each, and an evaluation of every policy."""
    folder = tmp_path_factory.mktemp("bandit")
    for reward in ("plain", "scaled", "shifted"):
        for seed in range(SEEDS):
            train(folder / f"{reward}-{seed}", reward, seed, evaluated=True)
    return load_study(folder)


def own(reward, manner):
    """Mean return of the trainings by a reward, paid by the env itself."""
    part = {TRAINING: slice(None), LAST: slice(-2, None), EVALUATION: slice(-1, None)}[manner]
    return float(np.mean([PULLS * np.mean(pulled(reward, seed)[part]) for seed in range(SEEDS)]))


@pytest.mark.parametrize("manner", [TRAINING, LAST, EVALUATION])
def test_a_reward_that_only_scales_is_a_ruler_of_its_factor(study, manner):
    """The ratio is 3 x behaviour, and the behaviour is what the env itself pays more, to 1e-9."""
    split = study.combinations[0].number.returns[manner]
    behaviour = own("scaled", manner) / own("plain", manner)
    assert study.combinations[0].names == ("plain", "scaled")
    assert split.ratio.ruler.value == pytest.approx(FACTOR, abs=1e-9)
    assert split.ratio.behaviour.value == pytest.approx(behaviour, abs=1e-9)
    assert split.ratio.eta.value == pytest.approx(FACTOR * behaviour, abs=1e-9)
    assert split.ratio.interaction.value == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("manner", [TRAINING, LAST, EVALUATION])
def test_a_reward_that_only_adds_is_a_ruler_of_what_it_adds(study, manner):
    """The difference is 2 for each pull, ruler, and what the env itself pays more, behaviour, to 1e-9."""
    split = study.combinations[1].number.returns[manner]
    assert study.combinations[1].names == ("plain", "shifted")
    assert split.total.ruler.value == pytest.approx(BONUS * PULLS, abs=1e-9)
    assert split.total.behaviour.value == pytest.approx(own("shifted", manner) - own("plain", manner), abs=1e-9)


def test_the_full_table_is_known_in_closed_form(study):
    """Every training paid by every reward."""
    pays = {"plain": lambda r: r, "scaled": lambda r: FACTOR * r, "shifted": lambda r: r + BONUS * PULLS}
    for (payer, trained), mean in paid_in(study, TRAINING).items():
        assert mean.value == pytest.approx(pays[payer](own(trained, TRAINING)), abs=1e-9)


def test_the_index_of_the_summed_reward_is_split_by_the_same_ruler(study):
    """The summed curve is never negative: I_P alone, and its ruler is the factor."""
    comparison = study.combinations[0]
    assert list(comparison.number.index_splits) == ["eta_P"]
    assert comparison.number.index_splits["eta_P"].ruler.value == pytest.approx(FACTOR, abs=1e-9)
    assert set(comparison.curves) == {*product(("baseline", "proposed"), repeat=2)}


def test_evaluations_decide_where_they_were_recorded(study):
    """`plain` and `scaled` end with actions above 1 in all seeds, `shifted` never: the final policies say so."""
    scaled, shifted = study.combinations
    assert {it.manner for it in study.combinations} == {EVALUATION}
    assert (scaled.decisive.baseline, scaled.decisive.proposed) == (1.0, 1.0)
    assert shifted.headline.answer.value == "hurts"
    assert "rests on evaluations of the final policies, 3 episodes" in basis_text(shifted)
