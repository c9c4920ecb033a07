"""Broken algorithms. The one that is broken is small: from an action it goes to the best of a few around it."""

import itertools
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, ClassVar

import numpy as np

from harness import load_registry
from harness.algorithm import Progress, as_state, pack_generator, restore_generator
from harness.policy import SquashedGaussian

from . import mutant

EPISODE = 20
"""Steps that each candidate is tried."""


@dataclass(frozen=True)
class Search:
    """Random search; each env tries a candidate of its own, and the best one is the next to search around.

    The methods are what the mutants break, one each.
    """

    num_envs: ClassVar[int] = 4
    action_spaces: ClassVar[Any] = frozenset({"continuous"})
    box: ClassVar[float] = 1.0
    policy: ClassVar[type] = SquashedGaussian

    def train(self, env, steps, seed, progress):
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
        return self.policy_of(best.astype(np.float32), env.single_observation_space.shape[0])

    def keep(self, done, best, rng):
        return as_state({"done": done, "best": best, "rng": pack_generator(rng)})

    def generator(self, seed):
        return np.random.default_rng(seed)

    def start(self, env, seed):
        env.reset()

    def act(self, candidates):
        return np.tanh(candidates)

    def read(self, rewards):
        return rewards

    def may_learn(self, step):
        return True

    def choose(self, returns):
        return int(returns.argmax())

    def finish(self, env, steps, progress):
        progress(steps)

    def try_out(self, env, candidates, periods):
        returns, running = np.zeros(self.num_envs), np.ones(self.num_envs, bool)
        for _ in range(periods):
            _, rewards, terminated, truncated, _ = env.step(self.act(candidates).astype(np.float32))
            returns += np.where(running, self.read(rewards), 0.0)
            running &= ~(terminated | truncated)
        env.reset()
        return returns

    def policy_of(self, best, size):
        none, ends = np.zeros((len(best), size), np.float32), (self.box,) * len(best)
        weights = {"mean.weight": none, "mean.bias": best, "log_std.weight": none.copy(), "log_std.bias": 0.0 * best}
        return self.policy(weights, "relu", tuple(-end for end in ends), ends)


class CarelessPolicy(SquashedGaussian):
    """A policy that rounds what it saves."""

    def save(self, folder, cell=None):
        rounded = {name: np.float32(np.float16(weight)) for name, weight in self.weights.items()}
        SquashedGaussian(rounded, self.activation, self.action_low, self.action_high).save(folder, cell)


def looks_once_more(self, env, steps, progress):
    """In the end."""
    env.step(np.zeros(env.action_space.shape, np.float32))
    progress(steps)


def draws_and_keeps(self, done, best, rng):
    """Making a checkpoint takes a random number."""
    rng.random()
    return Search.keep(self, done, best, rng)


def searches(**changed):
    """The search with another method."""
    return mutant(Search, **changed)


LEARNER = (
    load_registry()
    .get("algorithms", "sac-fast")
    .load()(net_arch=(32,), batch_size=64, learning_starts=50, learning_rate=3e-3)
)


@dataclass(frozen=True)
class Exporting:
    """A real learner, whose policy is put together by `export`; it may keep its policy to itself until the end."""

    export: Callable[[Any], Any]
    tells: bool = True

    num_envs: ClassVar[int] = 1
    action_spaces: ClassVar[Any] = frozenset({"continuous"})

    def train(self, env, steps, seed, progress):
        return self.export(LEARNER.train(env, steps, seed, Passing(progress, self)))


class Passing(Progress):
    """Passes on steps, and policies as they are exported."""

    def __init__(self, inner, exporting):
        self.inner, self.exporting = inner, exporting

    def __call__(self, steps):
        self.inner(steps)

    def policy(self, steps, make):
        if self.exporting.tells:
            self.inner.policy(steps, lambda: self.exporting.export(make()))


def as_it_is(policy):
    """Nothing is wrong with it."""
    return policy


def changed(change):
    """An export with other weights, by the name of each."""

    def export(policy):
        made = {name: np.ascontiguousarray(change(name, array), np.float32) for name, array in policy.weights.items()}
        return replace(policy, weights=made)

    return export


def half_the_box(policy):
    """The ends of the actions are those of another env."""
    low, high = (tuple(0.5 * end for end in ends) for ends in (policy.action_low, policy.action_high))
    return replace(policy, action_low=low, action_high=high)


SMALL = {
    "without its last bias": changed(lambda name, array: 0.0 * array if name == "mean.bias" else array),
    "without biases": changed(lambda name, array: 0.0 * array if name.endswith("bias") else array),
}
"""Too small a change to be seen where the policy is compared only roughly."""
WRONG = {
    "in reverse": changed(lambda name, array: array[::-1] if name.startswith("mean") else array),
    "scaled twice": changed(lambda name, array: 3.0 * array if name == "mean.weight" else array),
    "negated": changed(lambda name, array: -array if name.startswith("mean") else array),
    "in half the box": half_the_box,
}
SOUND = (Search(),)
MUTANTS = {
    "lists its spaces": ("algo-action-spaces", searches(action_spaces=["continuous"])),
    "takes one step more": ("algo-budget", searches(finish=looks_once_more)),
    "forgets the end": ("algo-progress", searches(finish=lambda self, env, steps, told: told(steps - 1)), "[199]"),
    "goes back": (
        "algo-progress",
        searches(finish=lambda self, env, steps, told: [told(it) for it in (steps, 1, steps)]),
        "cannot be",
    ),
    "seeds the env": ("algo-env-seed", searches(start=lambda self, env, seed: env.reset(seed=seed))),
    "acts beyond the box": ("algo-training-actions", searches(act=lambda self, candidates: 2.0 * np.tanh(candidates))),
    "yields a broad policy": ("algo-policy-actions", searches(box=1.5)),
    "counts its trainings": (
        "algo-same-seed",
        searches(
            count=itertools.count(),
            generator=lambda self, seed: np.random.default_rng([seed, next(self.count) if seed else 0]),
        ),
    ),
    "ignores its seed": ("algo-other-seed", searches(generator=lambda self, seed: np.random.default_rng(0))),
    "stops early": ("algo-goes-on", searches(may_learn=lambda self, step: step < 160)),
    "never goes on": ("algo-goes-on", searches(may_learn=lambda self, step: False)),
    "never learns": ("algo-learns", searches(may_learn=lambda self, step: False)),
    "never looks": ("algo-every-env", searches(may_learn=lambda self, step: False)),
    "reads another env's reward": ("algo-learns", searches(read=lambda self, rewards: np.roll(rewards, 1))),
    "minimises": ("algo-learns", searches(read=lambda self, rewards: -rewards)),
    "reads the first env's reward": (
        "algo-every-env",
        searches(read=lambda self, rewards: np.full_like(rewards, rewards[0])),
        "whatever env 1 of 4",
    ),
    "leaves an env out": (
        "algo-every-env",
        searches(choose=lambda self, returns: int(returns[:-1].argmax())),
        "whatever env 3 of 4",
    ),
    "ignores its goals": ("algo-hindsight", searches(needs_goals=True)),
    "denies that it learns": ("algo-learns-nothing", searches(learns=False)),
    "saves carelessly": ("algo-policy-saved", searches(policy=CarelessPolicy)),
    "draws for its checkpoint": ("algo-checkpoint-silent", searches(keep=draws_and_keeps)),
    "forgets its generator": (
        "algo-resume",
        searches(keep=lambda self, done, best, rng: Search.keep(self, done, best, self.generator(0))),
    ),
    "a policy of half the box": ("algo-policy-box", Exporting(half_the_box), "action_low of the policy is (-0.5"),
    "tells no policy": ("algo-tells-policy", Exporting(as_it_is, tells=False)),
    "leaves no checkpoint": ("algo-leaves-checkpoints", Exporting(as_it_is, tells=False)),
    "slow": (
        "algo-slow",
        searches(act=lambda self, candidates: time.sleep(0.1) or np.tanh(candidates)),
        "a step of training takes ",
    ),
    **{
        f"a policy {how}": (
            "algo-acts-as-trained",
            Exporting(export),
            "of the actions in training are above the policy's action",
        )
        for how, export in {**SMALL, **WRONG}.items()
    },
    **{
        f"a policy {how}, told in the end": ("algo-acts-as-trained", Exporting(export, tells=False))
        for how, export in WRONG.items()
    },
}
