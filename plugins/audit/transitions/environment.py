"""The rewards of an environment that a plugin names, beside one another; see `audit_rewards`."""

from collections.abc import Sequence
from contextlib import closing
from dataclasses import replace

from harness.environment import Environment
from harness.experiment.environments.plan import columns_of, look_at
from harness.registry import Choice, Registry, choose
from harness.registry.spec import blamed_on

from ..audit import Audit
from ..search.place import places_in_environment
from ..subject import Answered, Asked
from .audit_rewards import EPISODES, GAMMA, audit_rewards


def audit_environment(
    task: Choice,
    registry: Registry,
    rewards: Sequence[str],
    against: str | None,
    gamma: float,
    episodes: int | None,
) -> Audit:
    """How far apart rewards are in an environment, in the steps of random actions and beside steps nobody took.

    Args:
        task: The environment.
        registry: The plugins; functions in files that the user gave are rewards and measures too.
        rewards: Which of its rewards, ``hover``, ``hover:effort=2``; all if empty.
        against: The one that they are compared with, by default the environment's baseline.
        gamma: Discount per step, above 0 and below 1.
        episodes: Of random actions in each of 5 measurements; None for as many as `audit_rewards` takes.

    Raises:
        UsageError: A reward is not known, or fails in a step.
        PluginError: The environment raises; says whose it is.
    """
    looked = look_at(task, registry)
    baseline, choices = looked.rewards_asked(against, rewards or None)
    environment: Environment = task.build(registry, "environments")
    with blamed_on(registry.get("environments", task.name), "it was audited"), closing(environment.make()) as env:
        columns = columns_of(environment, env, registry, (baseline, *choices))
        named = dict.fromkeys(choice.label for choice in (baseline, *choices))
        given = {name: columns.rewards[name] for name in named}
        found = audit_rewards(
            env,
            given,
            gamma=gamma,
            episodes=EPISODES if episodes is None else episodes,
            behaviour=columns.behaviour,
            compared=tuple(named),
        )
        if env.spec is not None:
            return found
        title = found.title.replace(found.facts["env"], task.label, 1)  # what was typed, of a class without an id
        return replace(found, title=title, facts={**found.facts, "env": task.label})


def audited(asked: Asked) -> Answered:
    """An audit of all rewards, and where a search looks; see `audit_environment`."""
    task = choose(asked.registry, "environments", asked.named)
    gamma = GAMMA if asked.gamma is None else asked.gamma
    found = audit_environment(task, asked.registry, asked.rewards, asked.against, gamma, asked.episodes)
    return [found], places_in_environment(asked.registry, task, asked.rewards, gamma, asked.success)
