"""The interface that an environment fills: any Gymnasium environment, with names for its rewards and its behaviour."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import gymnasium

from harness.arrays import Float
from harness.errors import UsageError
from harness.eta.interval import Bounds
from harness.face import lookup
from harness.reward.given import Given

AnyEnv: TypeAlias = gymnasium.Env[Any, Any]
GoalReward: TypeAlias = Callable[[Float, Float], Float]
"""A function of (achieved goals, desired goals), both (n, goal_size), that returns what n steps are paid, (n,)."""
SUCCESS = "success"
"""The measure of behaviour that decides whether a robot behaves better, if an environment has one of this name."""


class Environment(Protocol):
    """A frozen dataclass whose fields are the parameters.

    It may also have these members:

    * ``lower_is_better`` and ``higher_is_better``: names of measures, see `lower_is_better`.
    * ``bounds``: by name of a measure, the least and the greatest value that it can have, see `bounds_of`.
    * ``baseline``: the name of the reward that the others are compared with, see `baseline_of`.
    * ``examples()``: parameters to try it with, if some have no default, see `examples_of`.
    * ``make_together(count)``: if one program moves several robots, see `envs_together`.
    * ``goal_rewards(env)``: if observations are dicts with achieved and desired goals, see `goal_rewards`.
    * ``sources``: the modules that it works in, see `harness.registry.sources.source_files`.
    """

    def make(self) -> AnyEnv:
        """A new env. It draws everything random from the generator that ``reset`` seeds, and should end its episodes.

        A training in which no episode ends has no returns; episodes of evaluations are cut at the cell's horizon.
        """

    def rewards(self, env: AnyEnv) -> Mapping[str, Given]:
        """The rewards of one env, by name, at least one. One of them pays a training; all of them are recorded.

        A function may read `env`, which is then in the state right after the step. It must change nothing there.

        Args:
            env: An env that `make` made. Functions get its observations as they are: nothing is flattened.
        """

    def behaviour(self, env: AnyEnv) -> Mapping[str, Given]:
        """Measures of what the robot does, by name; see `rewards`. They should not depend on any reward.

        A measure's value in the last step of an episode is its value for the episode. The measure ``success`` decides
        whether a robot behaves better. If there is none of this name, the first measure decides.
        """


def envs_together(environment: Environment, count: int) -> list[AnyEnv]:
    """So many envs for one training: what ``make_together(count)`` returns, else one of `make` after the other.

    Envs that one program moves take their step at the same time. Such an env has a method ``announce(action)``. Before
    they take a step, each is told its action, see `announce_all`.
    """
    ask = getattr(environment, "make_together", None)
    return list(ask(count)) if ask else [environment.make() for _ in range(count)]


def announce_all(envs: Sequence[AnyEnv], actions: Sequence[Any]) -> None:
    """Tell envs of one program what each does in the step that all of them take next; others are told nothing."""
    for env, action in zip(envs, actions, strict=True):
        announce = getattr(env.unwrapped, "announce", None)
        if announce is not None:
            announce(action)


def lower_is_better(environment: Environment) -> frozenset[str]:
    """Names of the measures of which less is better; none if the environment does not name any.

    A measure that is not 0 or 1 and stands neither here nor in `higher_is_better` decides nothing: its numbers are
    shown without a word.
    """
    return frozenset(getattr(environment, "lower_is_better", ()))


def higher_is_better(environment: Environment) -> frozenset[str]:
    """Names of the measures of which more is better; none if the environment does not name any."""
    return frozenset(getattr(environment, "higher_is_better", ()))


def bounds_of(environment: Environment) -> dict[str, Bounds]:
    """The least and the greatest value of each measure for which the environment names them; either may be infinite.

    No interval in a report leaves them. A measure that is 0 or 1 in every episode needs none.
    """
    return dict(getattr(environment, "bounds", {}))


def examples_of(environment: Any) -> dict[str, tuple[str, ...]]:
    """Parameters that an environment, or its class, can be tried with, ``{"id=CartPole-v1": ()}``.

    Beside each stand the modules that it takes. ``harness doctor`` makes an env of each whose modules are installed.
    They are what a static method ``examples()`` returns. Without that method the defaults are tried.
    """
    ask = getattr(environment, "examples", None)
    return {text: tuple(modules) for text, modules in ask().items()} if ask else {}


def baseline_of(environment: Environment, rewards: Mapping[str, Given]) -> str:
    """The reward that the others are compared with: the environment's ``baseline``, or the first of its rewards."""
    return str(getattr(environment, "baseline", "") or next(iter(rewards)))


def goal_rewards(environment: Environment, env: AnyEnv) -> dict[str, GoalReward]:
    """Those of its rewards that depend on goals only, by name; none if the environment has no ``goal_rewards``.

    Such a reward pays a step by the ``achieved_goal`` and the ``desired_goal`` of the observation after it. So it can
    also say what the step would have been paid with another goal.
    """
    ask = getattr(environment, "goal_rewards", None)
    return dict(ask(env)) if ask else {}


def rewards_of(environment: Environment, env: AnyEnv) -> dict[str, Given]:
    """The rewards.

    Raises:
        UsageError: There is none.
    """
    rewards = dict(environment.rewards(env))
    if not rewards:
        raise UsageError("the environment names no reward: it has to name one at least")
    return rewards


if not TYPE_CHECKING:
    __getattr__ = partial(lookup, __name__)

__all__ = ["AnyEnv", "Environment", "GoalReward"]
