"""What is recorded of an env: the environment's own rewards and measures, and those that the user gave as files."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

from harness.environment import (
    SUCCESS,
    AnyEnv,
    Environment,
    bounds_of,
    higher_is_better,
    lower_is_better,
    rewards_of,
)
from harness.errors import UsageError
from harness.eta.interval import UNBOUNDED, Bounds
from harness.registry.measure_functions import EPISODE
from harness.registry.registry import Registry
from harness.registry.step_functions import StepFunction
from harness.reward.forms import STEP
from harness.reward.given import Given, Terms, opened


@dataclass(frozen=True)
class Columns:
    """What is recorded of each step of one env.

    Attributes:
        rewards: By name; the environment's own first.
        behaviour: By name; the measure that decides first.
        lower_is_better: Names of the measures of which less is better.
        higher_is_better: The same of more.
        bounds: By name of a measure, the least and the greatest value that it can have.
    """

    rewards: Mapping[str, Given]
    behaviour: Mapping[str, Given]
    lower_is_better: Collection[str]
    higher_is_better: Collection[str] = ()
    bounds: Mapping[str, Bounds] = field(default_factory=dict)


def columns_of(environment: Environment, env: AnyEnv, registry: Registry) -> Columns:
    """What is recorded of one env of an environment.

    The measure called ``success`` decides, else the first one that the user gave, else the environment's first.

    Raises:
        UsageError: The environment has no reward, or two of these have one name.
    """
    rewards, measures = registry.functions_of("reward"), registry.functions_of("measure")
    own, own_behaviour = rewards_of(environment, env), dict(environment.behaviour(env))
    _require_other_names(rewards, own)
    _require_other_names(measures, own_behaviour)
    for it in measures.values():
        if it.is_of_episodes:
            raise UsageError(
                f"Plugin file '{it.file.path}': the measure '{it.name}' takes ({EPISODE}), and whole episodes are "
                f"measured of an arm alone. In an environment write {it.name}({STEP}): the last step counts"
            )
    behaviour = {**_made(measures), **own_behaviour}
    return Columns(
        {**own, **_made(rewards)},
        {**{name: behaviour[name] for name in behaviour if name == SUCCESS}, **behaviour},
        {*lower_is_better(environment), *(it.name for it in measures.values() if it.better == "lower")},
        {*higher_is_better(environment), *(it.name for it in measures.values() if it.better == "higher")},
        {
            **bounds_of(environment),
            **{it.name: it.bounds for it in measures.values() if it.bounds != UNBOUNDED},
        },
    )


def weighing(columns: Columns, name: str, label: str, weights: Mapping[str, float]) -> Columns:
    """The same, and a reward of the name `label` that pays the terms of one of its rewards times weights."""
    if not weights:
        return columns
    weighted = Terms({name: opened(columns.rewards[name], f"reward {name!r}")}, weights)
    return replace(columns, rewards={**columns.rewards, label: weighted})


def _made(functions: Mapping[str, StepFunction]) -> dict[str, Given]:
    return {name: it.make() for name, it in functions.items()}


def _require_other_names(given: Mapping[str, StepFunction], own: Mapping[str, Given]) -> None:
    for name in given.keys() & own.keys():
        it = given[name]
        raise UsageError(
            f"Plugin file '{it.file.path}': the environment has a {it.noun} '{name}' of its own. Rename yours"
        )
