"""What an algorithm must satisfy. Each check takes the algorithm.

They train it for real, on an easy task without an engine, with the hyperparameters that it was given: `FEW` steps have
to be enough for it to begin learning, `MANY` to learn something.
"""

import random
import tempfile
from pathlib import Path

import numpy as np

from harness.algorithm import Algorithm
from harness.policy import Policy
from harness.testing.trainings import mean_return, observations, steps_for, train
from harness.testing.violations import raise_first, require, settings_are_frozen, settings_survive_json

FEW, MANY = 200, 1000
MIN_RISE = 5.0
"""Of the mean return, [m]: 20 steps on the way instead of away from it bring several times as much."""


def check_algorithm(algorithm: Algorithm) -> None:
    """Run all `ALGORITHM_CHECKS`.

    Raises:
        ContractViolation: At the first check that fails.
    """
    raise_first(ALGORITHM_CHECKS, algorithm)


def action_spaces_are_declared(algorithm: Algorithm) -> None:
    """`action_spaces` is a frozenset of ``continuous``, ``discrete`` or both."""
    spaces = algorithm.action_spaces
    known = isinstance(spaces, frozenset) and spaces and spaces <= {"continuous", "discrete"}
    require(known, f"action_spaces is {spaces!r}, not a frozenset of 'continuous' and 'discrete'")


def the_budget_is_spent_exactly(algorithm: Algorithm) -> None:
    """Training takes as many environment steps as it was given, counted over all envs."""
    taken, given = train(algorithm, FEW).env.steps, steps_for(algorithm, FEW)
    require(taken == given, f"{taken} environment steps were taken, {given} were given")


def progress_is_told_to_the_end(algorithm: Algorithm) -> None:
    """`progress` hears of ever more steps; the last it hears is the budget."""
    told, given = train(algorithm, FEW).told, steps_for(algorithm, FEW)
    require(told and told[-1] == given, f"progress was told {told[-3:]} in the end, {given} steps were given")
    require(told == sorted(told), f"progress was told {told}: steps that are done cannot be undone")


def the_env_keeps_its_seed(algorithm: Algorithm) -> None:
    """Training resets the env without a seed: starts and targets are the same for every algorithm and reward."""
    seeds = train(algorithm, FEW).env.seeds
    require(all(seed is None for seed in seeds), f"the env was reset with the seed {seeds}")


def actions_of_training_are_in_the_box(algorithm: Algorithm) -> None:
    """Every action while training is finite and in the env's action space."""
    require(train(algorithm, FEW).env.actions_in_box, "an action was outside the env's action space")


def actions_of_the_policy_are_in_the_box(algorithm: Algorithm) -> None:
    """The policy's actions, with noise and without, are finite, in the action space, one row per observation."""
    done = train(algorithm, FEW)
    space, seen = done.env.single_action_space, observations()
    for rng in (None, np.random.default_rng(0)):
        actions = done.policy.act(seen, rng)
        shape = (len(seen), *(space.shape or ()))
        require(actions.shape == shape, f"{len(seen)} observations gave actions of shape {actions.shape}, not {shape}")
        require(all(map(space.contains, actions)), f"an action is outside the action space: {actions}")


def the_same_seed_gives_the_same_policy(algorithm: Algorithm) -> None:
    """Two trainings with one seed give the same weights, bit for bit, whatever else drew random numbers before."""
    first = train(algorithm, FEW, seed=1).policy
    np.random.random(7)
    random.random()
    require(_same_weights(first, train(algorithm, FEW, seed=1).policy), "the same seed gave other weights")


def another_seed_gives_another_policy(algorithm: Algorithm) -> None:
    """Two trainings with two seeds give different weights: the seed is used."""
    first, second = (train(algorithm, FEW, seed=seed).policy for seed in (1, 2))
    require(not _same_weights(first, second), "two seeds gave the same weights")


def learning_goes_on(algorithm: Algorithm) -> None:
    """A longer training changes the weights further: learning does not stop half-way."""
    first, second = (train(algorithm, steps).policy for steps in (FEW, 2 * FEW))
    require(not _same_weights(first, second), f"{2 * FEW} steps gave the weights of {FEW} steps")


def the_return_rises(algorithm: Algorithm) -> None:
    """On an easy task the trained policy's return is higher than that of a policy that was barely trained."""
    before, after = (mean_return(train(algorithm, steps).policy) for steps in (1, MANY))
    require(after > before + MIN_RISE, f"the return goes from {before:.2f} to {after:.2f} in {MANY} steps")


def the_policy_comes_back_from_its_folder(algorithm: Algorithm) -> None:
    """`Policy.load` gives what `save` wrote: it acts the same, bit for bit."""
    policy, seen = train(algorithm, FEW).policy, observations()
    with tempfile.TemporaryDirectory() as folder:
        policy.save(Path(folder) / "policy")
        loaded = Policy.load(Path(folder) / "policy")
    require(np.array_equal(policy.act(seen), loaded.act(seen)), "the loaded policy acts otherwise")


ALGORITHM_CHECKS = (
    settings_are_frozen,
    settings_survive_json,
    action_spaces_are_declared,
    the_budget_is_spent_exactly,
    progress_is_told_to_the_end,
    the_env_keeps_its_seed,
    actions_of_training_are_in_the_box,
    actions_of_the_policy_are_in_the_box,
    the_same_seed_gives_the_same_policy,
    another_seed_gives_another_policy,
    learning_goes_on,
    the_return_rises,
    the_policy_comes_back_from_its_folder,
)


def _same_weights(first: Policy, second: Policy) -> bool:
    return all(np.array_equal(first.weights[name], second.weights[name]) for name in first.weights)
