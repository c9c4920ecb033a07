"""What is recorded of an env: the environment's own rewards and measures, and those that the user gave as files."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

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
from harness.recorder.column import for_env
from harness.registry.choice import Choice
from harness.registry.measure_functions import EPISODE
from harness.registry.registry import Registry
from harness.registry.spec import unknown_name
from harness.registry.step_functions import StepFunction
from harness.reward import Steps
from harness.reward.forms import STEP
from harness.reward.given import ARM, Given, OfArm, Terms, opened


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


def closest_distance(step: Steps) -> float:
    """How near the episode of an arm has come to its target, [m]."""
    return float(min(step.info[ARM].previous_best[0], *step.info[ARM].distance))


def ground_hits(step: Steps) -> bool:
    """Whether the step of an arm touched the ground."""
    return bool(step.info[ARM].ground.any())


ARM_MEASURES: Mapping[str, Given] = MappingProxyType(
    {
        SUCCESS: "is_success",
        "final_distance": "distance",
        "closest_distance": closest_distance,
        "ground_hits": ground_hits,
    }
)
"""Measures of an arm that the last step of an episode tells. Of all but success less is better."""


def columns_of(environment: Environment, env: AnyEnv, registry: Registry, named: Iterable[Choice] = ()) -> Columns:
    """What is recorded of one env of an environment: this is where the name of a reward gets its meaning there.

    The measure called ``success`` decides, else the first one that the user gave, else the environment's first.

    Args:
        environment: The environment.
        env: The env. One of an arm is measured as an arm, and an arm's rewards can pay it.
        registry: The plugins.
        named: Rewards to have beside those of the environment and of files: with weights of their terms, or an arm's.

    Raises:
        UsageError: The environment has no reward, or two of these have one name.
    """
    rewards, measures = registry.functions_of("reward"), registry.functions_of("measure")
    of_arm = ARM_MEASURES if env.metadata.get(ARM) else {}
    own, own_behaviour = rewards_of(environment, env), {**of_arm, **environment.behaviour(env)}
    _require_other_names(rewards, own)
    _require_other_names(measures, own_behaviour)
    for it in measures.values():
        if it.is_of_episodes:
            raise UsageError(
                f"Plugin file '{it.file.path}': the measure '{it.name}' takes ({EPISODE}), and whole episodes are "
                f"measured of an arm alone. In an environment write {it.name}({STEP}): the last step counts"
            )
    behaviour = {**_made(measures), **own_behaviour}
    given = {name: for_env(env, it) for name, it in {**own, **_made(rewards)}.items()}
    return Columns(
        {**given, **{it.label: _named(it, given, env, registry) for it in named}},
        {**{name: behaviour[name] for name in behaviour if name == SUCCESS}, **behaviour},
        {*of_arm.keys() - {SUCCESS}, *lower_is_better(environment), *_better(measures, "lower")},
        {*higher_is_better(environment), *_better(measures, "higher")},
        {
            **bounds_of(environment),
            **{it.name: it.bounds for it in measures.values() if it.bounds != UNBOUNDED},
        },
    )


def _named(choice: Choice, given: Mapping[str, Given], env: AnyEnv, registry: Registry) -> Given:
    """A reward of the environment, perhaps with weights of its terms; else the arm's of that name."""
    if choice.name not in given:
        if not env.metadata.get(ARM):
            raise UsageError(unknown_name("reward", choice.name, given))
        return OfArm(choice.build(registry, "rewards"))
    own, weights = given[choice.name], dict(choice.params)
    return Terms({choice.name: opened(own, f"reward {choice.name!r}")}, weights) if weights else own


def _made(functions: Mapping[str, StepFunction]) -> dict[str, Given]:
    return {name: it.make() for name, it in functions.items()}


def _better(measures: Mapping[str, StepFunction], direction: str) -> list[str]:
    return [name for name, it in measures.items() if it.better == direction]


def _require_other_names(given: Mapping[str, StepFunction], own: Mapping[str, Given]) -> None:
    for name in given.keys() & own.keys():
        it = given[name]
        raise UsageError(
            f"Plugin file '{it.file.path}': the environment has a {it.noun} '{name}' of its own. Rename yours"
        )
