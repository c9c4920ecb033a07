"""Every algorithm check has a broken algorithm that fails it, and no other.

The algorithm that is broken is a small one: from an action it goes to the best of a few around it.
"""

# ruff: noqa: D102 (a mutant says what is wrong with it once, on the class)

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from harness.authoring.generator_state import pack_generator, restore_generator
from harness.env import ReachVectorEnv
from harness.policy import Policy, SquashedGaussian
from harness.progress import Progress, TrainingState, as_state
from harness.testing import ALGORITHM_CHECKS, algorithms, violations

EPISODE = 20
"""Steps that each candidate is tried."""


class Search:
    """Random search; each env tries a candidate of its own, and the best one is the next to search around.

    The methods are what the mutants break, one each.
    """

    num_envs: ClassVar[int] = 4
    action_spaces: ClassVar[Any] = frozenset({"continuous"})

    def train(self, env: ReachVectorEnv, steps: int, seed: int, progress: Progress) -> Policy:
        rng, state = self.generator(seed), progress.restored()
        if state is None:
            self.start(env, seed)
            best, begun = 0.1 * rng.standard_normal(env.robot.dof), 0
        else:
            restore_generator(rng, state["rng"])
            best, begun = state["best"], int(state["done"])
        for first in range(begun, steps, self.num_envs * EPISODE):
            periods = min(EPISODE, (steps - first) // self.num_envs)
            candidates = best + 0.5 * rng.standard_normal((self.num_envs, env.robot.dof))
            returns = self.try_out(env, candidates, periods)
            if periods == EPISODE and self.may_learn(first):
                best = candidates[self.choose(returns)]
            done = first + periods * self.num_envs
            progress.checkpoint(done, partial(self.keep, done, best, rng))
        self.finish(env, steps, progress)
        return self.policy(best.astype(np.float32), env.single_observation_space.shape[0])

    def keep(self, done: int, best: np.ndarray, rng: np.random.Generator) -> TrainingState:
        return as_state({"done": done, "best": best, "rng": pack_generator(rng)})

    def generator(self, seed: int) -> np.random.Generator:
        return np.random.default_rng(seed)

    def start(self, env: ReachVectorEnv, seed: int) -> None:
        env.reset()

    def act(self, candidates: np.ndarray) -> np.ndarray:
        return np.tanh(candidates)

    def read(self, rewards: np.ndarray) -> np.ndarray:
        return rewards

    def may_learn(self, step: int) -> bool:
        return True

    def choose(self, returns: np.ndarray) -> int:
        return int(returns.argmax())

    def finish(self, env: ReachVectorEnv, steps: int, progress: Progress) -> None:
        progress(steps)

    def try_out(self, env: ReachVectorEnv, candidates: np.ndarray, periods: int) -> np.ndarray:
        returns, running = np.zeros(self.num_envs), np.ones(self.num_envs, bool)
        for _ in range(periods):
            _, rewards, terminated, truncated, _ = env.step(self.act(candidates).astype(np.float32))
            returns += np.where(running, self.read(rewards), 0.0)
            running &= ~(terminated | truncated)
        env.reset()
        return returns

    def policy(self, best: np.ndarray, observation_size: int) -> Policy:
        return SquashedGaussian(self.weights(best, observation_size), "relu", (-1.0,) * len(best), (1.0,) * len(best))

    def weights(self, best: np.ndarray, observation_size: int) -> dict[str, np.ndarray]:
        nothing = np.zeros((len(best), observation_size), np.float32)
        return {
            "mean.weight": nothing, "mean.bias": best, "log_std.weight": nothing.copy(), "log_std.bias": 0.0 * best,
        }  # fmt: skip


@dataclass(frozen=True)
class Sound(Search):
    """Nothing is wrong with it."""


@dataclass
class Thawed(Search):
    """Its hyperparameters can be changed while it runs."""


@dataclass(frozen=True)
class SetUpWithASet(Search):
    """JSON knows no sets."""

    layers: frozenset[int] = frozenset({64})


class ListsItsSpaces(Sound):
    """The action spaces are a list."""

    action_spaces = ["continuous"]  # noqa: RUF012 (what is wrong with it)


class TakesOneStepMore(Sound):
    """It looks at the env once more in the end."""

    def finish(self, env: ReachVectorEnv, steps: int, progress: Progress) -> None:
        env.step(np.zeros(env.action_space.shape, np.float32))
        progress(steps)


class ForgetsTheEnd(Sound):
    """Progress stops short of the budget."""

    def finish(self, env: ReachVectorEnv, steps: int, progress: Progress) -> None:
        progress(steps - 1)


class GoesBack(Sound):
    """Progress is told out of order."""

    def finish(self, env: ReachVectorEnv, steps: int, progress: Progress) -> None:
        for told in (steps, 1, steps):
            progress(told)


class SeedsTheEnv(Sound):
    """It resets the env with its own seed."""

    def start(self, env: ReachVectorEnv, seed: int) -> None:
        env.reset(seed=seed)


class ActsBeyondTheBox(Sound):
    """It trains with actions twice as large as allowed."""

    def act(self, candidates: np.ndarray) -> np.ndarray:
        return 2.0 * np.tanh(candidates)


class YieldsABroadPolicy(Sound):
    """The policy's action box is too large."""

    def policy(self, best: np.ndarray, observation_size: int) -> Policy:
        return SquashedGaussian(self.weights(best, observation_size), "relu", (-1.5,) * len(best), (1.5,) * len(best))


class CountsItsTrainings(Sound):
    """What it draws depends on how often it was called, but for seed 0."""

    count = itertools.count()

    def generator(self, seed: int) -> np.random.Generator:
        return np.random.default_rng([seed, next(self.count) if seed else 0])


class IgnoresItsSeed(Sound):
    """It always draws the same."""

    def generator(self, seed: int) -> np.random.Generator:
        return np.random.default_rng(0)


class StopsEarly(Sound):
    """It learns nothing after the 160th step."""

    def may_learn(self, step: int) -> bool:
        return step < 160


class ReadsAnotherEnvsReward(Sound):
    """It takes the rewards of the envs in another order."""

    def read(self, rewards: np.ndarray) -> np.ndarray:
        return np.roll(rewards, 1)


class ReadsTheFirstEnvsReward(Sound):
    """It takes the reward of one env for that of all, and still learns from which episodes end."""

    def read(self, rewards: np.ndarray) -> np.ndarray:
        return np.full_like(rewards, rewards[0])


class LeavesAnEnvOut(Sound):
    """What the last env finds out is never looked at."""

    def choose(self, returns: np.ndarray) -> int:
        return int(returns[:-1].argmax())


class Minimises(Sound):
    """It has the sign of the reward wrong."""

    def read(self, rewards: np.ndarray) -> np.ndarray:
        return -rewards


class CarelessPolicy(SquashedGaussian):
    """A policy that rounds what it saves."""

    def save(self, folder: Path, cell: Any = None) -> None:
        rounded = {name: np.float32(np.float16(weight)) for name, weight in self.weights.items()}
        SquashedGaussian(rounded, self.activation, self.action_low, self.action_high).save(folder, cell)


class SavesCarelessly(Sound):
    """Its policy comes back as another one."""

    def policy(self, best: np.ndarray, observation_size: int) -> Policy:
        return CarelessPolicy(self.weights(best, observation_size), "relu", (-1.0,) * len(best), (1.0,) * len(best))


class NeverLearns(Sound):
    """Nothing that it sees makes a difference."""

    def may_learn(self, step: int) -> bool:
        return False


class DeniesThatItLearns(Sound):
    """It says that no training makes a difference."""

    learns: ClassVar[bool] = False


class DrawsForItsCheckpoint(Sound):
    """Making a checkpoint takes a random number."""

    def keep(self, done: int, best: np.ndarray, rng: np.random.Generator) -> TrainingState:
        rng.random()
        return super().keep(done, best, rng)


class ForgetsItsGenerator(Sound):
    """After a checkpoint it draws what it drew in the beginning."""

    def keep(self, done: int, best: np.ndarray, rng: np.random.Generator) -> TrainingState:
        return super().keep(done, best, self.generator(0))


MUTANTS = {
    Thawed: algorithms.settings_are_frozen,
    SetUpWithASet: algorithms.settings_survive_json,
    ListsItsSpaces: algorithms.action_spaces_are_declared,
    TakesOneStepMore: algorithms.the_budget_is_spent_exactly,
    ForgetsTheEnd: algorithms.progress_is_told_to_the_end,
    GoesBack: algorithms.progress_is_told_to_the_end,
    SeedsTheEnv: algorithms.the_env_keeps_its_seed,
    ActsBeyondTheBox: algorithms.actions_of_training_are_in_the_box,
    YieldsABroadPolicy: algorithms.actions_of_the_policy_are_in_the_box,
    CountsItsTrainings: algorithms.the_same_seed_gives_the_same_policy,
    IgnoresItsSeed: algorithms.another_seed_gives_another_policy,
    StopsEarly: algorithms.learning_goes_on,
    ReadsAnotherEnvsReward: algorithms.the_return_rises,
    Minimises: algorithms.the_return_rises,
    ReadsTheFirstEnvsReward: algorithms.every_env_counts,
    LeavesAnEnvOut: algorithms.every_env_counts,
    DeniesThatItLearns: algorithms.what_learns_nothing_says_so,
    SavesCarelessly: algorithms.the_policy_comes_back_from_its_folder,
    DrawsForItsCheckpoint: algorithms.checkpoints_change_nothing,
    ForgetsItsGenerator: algorithms.a_training_goes_on_where_it_stood,
}


def failing(mutant: type) -> list[str]:
    """Names of the checks that a mutant fails."""
    return [violation.check for violation in violations(ALGORITHM_CHECKS, mutant())]


@pytest.mark.parametrize(("mutant", "check"), MUTANTS.items())
def test_mutant_fails_one_check(mutant: type, check: Callable[..., None]):
    """An algorithm that is broken in one way fails the check of that fact, and no other."""
    assert failing(mutant) == [check.name]


def test_an_algorithm_that_never_learns_fails_all_checks_of_learning():
    """Weights that stay as they were drawn are noticed, and so is a return that stays."""
    assert failing(NeverLearns) == ["learning_goes_on", "the_return_rises", "every_env_counts"]


def test_every_check_has_a_mutant():
    """No check is without an algorithm that fails it alone."""
    assert set(MUTANTS.values()) == set(ALGORITHM_CHECKS)


def test_the_mutants_are_made_of_a_sound_algorithm():
    """What the mutants are made of fails nothing."""
    assert failing(Sound) == []
