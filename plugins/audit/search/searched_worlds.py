"""The worlds that a command searches, one for each reward: an arm's task, or an environment that a plugin brings."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, closing, contextmanager, nullcontext
from functools import partial
from typing import Any, TypeAlias

from harness.authoring.commands import (
    Choice,
    Registry,
    World as Arm,
    blamed_on,
    choose,
    look_at,
    split_list,
    usable,
)
from harness.task import choose_task

from .environment_world import of_environment
from .find import Search, find_in
from .finding import Finding
from .world import World

Watched: TypeAlias = Callable[[World], AbstractContextManager[Any]]
OTHERS = ("mujoco", "pybullet", "kinematic")
"""Simulators that an arm's behaviour is tried in, the first that is installed and is another one."""


@contextmanager
def arm_world(
    registry: Registry, reward: Choice, task: str, robot: str | None, sim: str | None, gamma: float
) -> Iterator[tuple[World, Mapping[str, Callable[[], World]]]]:
    """The world of one reward on an arm's task; and by its name, what makes the same in another simulator.

    Args:
        registry: The plugins.
        reward: The reward.
        task: The task, ``fd100-reach``.
        robot: The arm; None for the task's own.
        sim: The simulator; None for joints that move exactly as commanded.
        gamma: The learner's discount per step.

    Raises:
        UsageError: The robot cannot do the task.
        PluginError: The reward raises; says whose it is.
    """
    from harness.authoring.commands import IdealSimulator

    from .arm_world import ArmWorld

    chosen, arm = choose_task(registry, task, robot)
    where = sim and choose(registry, "simulators", sim)

    def make(simulator: Choice | None) -> World:
        engine = simulator.build(registry, "simulators") if simulator else IdealSimulator()
        built = Arm(engine, arm, chosen.build(registry, "tasks"), reward.build(registry, "rewards"))
        return ArmWorld(built, chosen.label, reward.label, gamma)

    there = [name for name in OTHERS if name in usable(registry, "simulators") and not (where and where.name == name)]
    others = {name: partial(make, choose(registry, "simulators", name)) for name in there[:1]}
    with blamed_on(registry.get("rewards", reward.name), "it was searched"), closing(make(where or None)) as world:
        yield world, others


def cheats_on_task(
    registry: Registry,
    rewards: Sequence[Choice],
    task: str,
    robot: str | None,
    sim: str | None,
    gamma: float,
    asked: Search,
    watched: Watched = nullcontext,
) -> tuple[Finding, ...]:
    """What a cheat would do for each reward on a task of an arm; see `arm_world`.

    Args:
        registry: The plugins.
        rewards: The rewards.
        task: The task.
        robot: The arm; None for the task's own.
        sim: The simulator; None for joints that move exactly as commanded.
        gamma: The learner's discount per step.
        asked: How much is searched.
        watched: Around each search, told its world.
    """
    found = []
    for reward in rewards:
        with arm_world(registry, reward, task, robot, sim, gamma) as (world, others), watched(world):
            found.append(find_in(world, asked, others))
    return tuple(found)


def cheats_in_environment(
    registry: Registry,
    task: Choice,
    rewards: str | None,
    gamma: float,
    success: str,
    asked: Search,
    watched: Watched = nullcontext,
) -> tuple[Finding, ...]:
    """What a cheat would do for each reward of an environment; see `of_environment` and `cheats_on_task`."""
    found = []
    for reward in environment_rewards(task, registry, rewards):
        with (
            blamed_on(registry.get("environments", task.name), "it was searched"),
            closing(of_environment(task, registry, reward, gamma, success)) as world,
            watched(world),
        ):
            found.append(find_in(world, asked))
    return tuple(found)


def environment_rewards(task: Choice, registry: Registry, rewards: str | None) -> tuple[Choice, ...]:
    """The rewards of an environment that are searched: those that are named, or all."""
    looked = look_at(task, registry)
    names = split_list(rewards) if rewards else looked.rewards
    return tuple(dict.fromkeys(looked.rewards_asked(name, ())[0] for name in names))
