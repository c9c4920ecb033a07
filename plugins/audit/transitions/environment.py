"""The rewards of an environment that a plugin names, beside one another; see `audit_rewards`."""

from contextlib import closing
from dataclasses import replace

from harness.environment import Environment
from harness.experiment.environments.plan import columns_of, look_at
from harness.registry import choose

from ..search.place import places_in_environment
from ..subject import Answered, Asked
from .audit_rewards import EPISODES, GAMMA, audit_rewards


def audited(asked: Asked) -> Answered:
    """How far apart rewards are in an environment, in the steps of random actions and beside steps nobody took.

    And where a search looks. Functions in files that the user gave are rewards and measures too.

    Raises:
        UsageError: A reward is not known, or fails in a step.
        PluginError: The environment raises; says whose it is.
    """
    registry, gamma = asked.registry, GAMMA if asked.gamma is None else asked.gamma
    task = choose(registry, "environments", asked.named)
    baseline, choices = look_at(task, registry).rewards_asked(asked.against, asked.rewards or None)
    environment: Environment = task.build(registry, "environments")
    with task.blamed(registry, "environments", "it was audited"), closing(environment.make()) as env:
        columns = columns_of(environment, env, registry, (baseline, *choices))
        named = dict.fromkeys(choice.label for choice in (baseline, *choices))
        given = {name: columns.rewards[name] for name in named}
        found = audit_rewards(
            env,
            given,
            gamma=gamma,
            episodes=EPISODES if asked.episodes is None else asked.episodes,
            behaviour=columns.behaviour,
            bounds=columns.bounds,
            compared=tuple(named),
        )
    if env.spec is None:  # what was typed, of a class without an id
        title = found.title.replace(found.facts["env"], task.label, 1)
        found = replace(found, title=title, facts={**found.facts, "env": task.label})
    return [found], places_in_environment(registry, task, asked.rewards, gamma, asked.success)
