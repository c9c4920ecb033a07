"""Every algorithm check has a broken algorithm that fails it, and no other.

The algorithm that is broken is a small one: from an action it goes to the best of a few around it.
"""

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from harness.authoring.generator_state import pack_generator, restore_generator
from harness.env import ReachVectorEnv
from harness.policy import Policy, SquashedGaussian
from harness.progress import Progress, TrainingState, as_state
from harness_plugins.algorithms.sac_fast import SacFast
from harness_plugins.kit import ALGORITHM_CHECKS, algorithms, violations

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


class IgnoresItsGoals(Sound):
    """It asks for goals, and never pays a step again for another one."""

    needs_goals: ClassVar[bool] = True


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
    CountsItsTrainings: algorithms.the_same_seed_gives_the_same_policy,
    IgnoresItsSeed: algorithms.another_seed_gives_another_policy,
    StopsEarly: algorithms.learning_goes_on,
    ReadsAnotherEnvsReward: algorithms.the_return_rises,
    Minimises: algorithms.the_return_rises,
    ReadsTheFirstEnvsReward: algorithms.every_env_counts,
    LeavesAnEnvOut: algorithms.every_env_counts,
    IgnoresItsGoals: algorithms.it_learns_in_hindsight,
    DeniesThatItLearns: algorithms.what_learns_nothing_says_so,
    SavesCarelessly: algorithms.the_policy_comes_back_from_its_folder,
    DrawsForItsCheckpoint: algorithms.checkpoints_change_nothing,
    ForgetsItsGenerator: algorithms.a_training_goes_on_where_it_stood,
}


COARSE_MUTANTS = {YieldsABroadPolicy: algorithms.actions_of_the_policy_are_in_the_box}


def failing(mutant: type) -> list[str]:
    """Names of the checks that a mutant fails."""
    return [violation.check for violation in violations(ALGORITHM_CHECKS, mutant())]


def test_mutant_fails_one_check(subtests: pytest.Subtests):
    """An algorithm that is broken in one way fails the check of that fact, and no other."""
    for mutant, check in MUTANTS.items():
        with subtests.test(mutant=mutant, check=check):
            assert failing(mutant) == [check.name]


@pytest.mark.parametrize(("mutant", "check"), COARSE_MUTANTS.items())
def test_coarse_mutant_fails_its_check(mutant: type, check: Callable[..., None]):
    """An algorithm that is broken in a way that shows in several places fails the check that is nearest."""
    assert check.name in failing(mutant)


def test_an_algorithm_that_never_learns_fails_all_checks_of_learning():
    """Weights that stay as they were drawn are noticed, and so is a return that stays."""
    assert failing(NeverLearns) == ["algo-goes-on", "algo-learns", "algo-every-env"]


def test_every_check_has_a_mutant():
    """No check is without an algorithm that fails it; the policies that do not act as they trained are below."""
    found = {*MUTANTS.values(), *COARSE_MUTANTS.values(), algorithms.the_policy_has_the_envs_actions}
    assert {*found, algorithms.the_policy_acts_as_it_trained} == set(ALGORITHM_CHECKS)


def test_the_mutants_are_made_of_a_sound_algorithm():
    """What the mutants are made of fails nothing."""
    assert failing(Sound) == []


LEARNER = SacFast(net_arch=(32,), batch_size=64, learning_starts=50, learning_rate=3e-3)


@dataclass(frozen=True)
class Exporting:
    """A real learner, whose policy is put together by `export`; it may keep its policy to itself until the end."""

    export: Callable[[SquashedGaussian], SquashedGaussian]
    tells: bool = True

    num_envs: ClassVar[int] = 1
    action_spaces: ClassVar[Any] = frozenset({"continuous"})

    def train(self, env: ReachVectorEnv, steps: int, seed: int, progress: Progress) -> Policy:
        return self.export(LEARNER.train(env, steps, seed, Passing(progress, self.export, self.tells)))


class Passing(Progress):
    """Passes on steps, and policies as they are exported."""

    def __init__(self, inner: Progress, export: Callable[[SquashedGaussian], SquashedGaussian], tells: bool) -> None:
        self.inner, self.export, self.tells = inner, export, tells

    def __call__(self, steps: int) -> None:
        self.inner(steps)

    def policy(self, steps: int, make: Callable[[], Policy]) -> None:
        if self.tells:
            self.inner.policy(steps, lambda: self.export(make()))  # type: ignore[arg-type]


def as_it_is(policy: SquashedGaussian) -> SquashedGaussian:
    """Nothing is wrong with it."""
    return policy


def in_reverse(policy: SquashedGaussian) -> SquashedGaussian:
    """The outputs come in another order."""
    return changed(policy, lambda name, array: array[::-1] if name.startswith("mean") else array)


def without_bias(policy: SquashedGaussian) -> SquashedGaussian:
    """The last layer has lost its bias."""
    return changed(policy, lambda name, array: 0.0 * array if name == "mean.bias" else array)


def without_biases(policy: SquashedGaussian) -> SquashedGaussian:
    """All layers have lost them."""
    return changed(policy, lambda name, array: 0.0 * array if name.endswith("bias") else array)


def three_times(policy: SquashedGaussian) -> SquashedGaussian:
    """The weights of the last layer are scaled twice."""
    return changed(policy, lambda name, array: 3.0 * array if name == "mean.weight" else array)


def negated(policy: SquashedGaussian) -> SquashedGaussian:
    """It does the opposite."""
    return changed(policy, lambda name, array: -array if name.startswith("mean") else array)


def half_the_box(policy: SquashedGaussian) -> SquashedGaussian:
    """The ends of the actions are those of another env."""
    low, high = (tuple(0.5 * end for end in ends) for ends in (policy.action_low, policy.action_high))
    return replace(policy, action_low=low, action_high=high)


def changed(policy: SquashedGaussian, change: Callable[[str, np.ndarray], np.ndarray]) -> SquashedGaussian:
    """A policy with other weights."""
    weights = {name: np.ascontiguousarray(change(name, array), np.float32) for name, array in policy.weights.items()}
    return replace(policy, weights=weights)


WRONG = (in_reverse, without_bias, without_biases, three_times, negated, half_the_box)
HARD_TO_SEE = (without_bias, without_biases)
"""Too small a change to be seen where the policy is compared only roughly."""


def test_a_wrong_policy_does_not_act_as_it_trained(subtests: pytest.Subtests):
    """Compared with the actions of training, at every step of it."""
    for export in WRONG:
        with subtests.test(export=export):
            (violation,) = violations([algorithms.the_policy_acts_as_it_trained], Exporting(export))
            assert "of the actions in training are above the policy's action" in violation.sentence


@pytest.mark.parametrize("export", [export for export in WRONG if export not in HARD_TO_SEE])
def test_a_wrong_policy_is_seen_where_it_is_told_in_the_end_alone(export: Callable[..., Any]):
    """Compared with the last actions of training, roughly."""
    assert list(violations([algorithms.the_policy_acts_as_it_trained], Exporting(export, tells=False)))


@pytest.mark.parametrize("tells", [True, False])
def test_a_right_policy_acts_as_it_trained(tells: bool):
    """Nothing is found."""
    checks = [algorithms.the_policy_acts_as_it_trained, algorithms.the_policy_has_the_envs_actions]
    assert list(violations(checks, Exporting(as_it_is, tells))) == []


def test_another_box_is_seen_at_once():
    """The policy's box is compared with the env's."""
    (violation,) = violations([algorithms.the_policy_has_the_envs_actions], Exporting(half_the_box))
    assert "action_low of the policy is (-0.5" in violation.sentence


def test_who_tells_nothing_is_warned():
    """No policy on the way, no checkpoints: the contract is kept, and two checks say what is lost."""
    found = list(violations(algorithms.ALGORITHM_WARNINGS, Exporting(as_it_is, tells=False)))
    assert [(violation.check, violation.level) for violation in found] == [
        ("algo-tells-policy", "warning"), ("algo-leaves-checkpoints", "warning"),
    ]  # fmt: skip
