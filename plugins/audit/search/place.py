"""What makes a world again, in another process or on another machine: names and numbers, never code."""

import platform
from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager, closing
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, StringConstraints, with_config

from harness.cli.runnable import usable
from harness.env.ideal import IdealSimulator
from harness.env.vector_env import World as Arm
from harness.environment import Environment
from harness.experiment.environments.plan import columns_of, look_at
from harness.experiment.provenance import describe_machine, versions_behind
from harness.files.plain import Plain
from harness.record.file_forms import EXACT, Chosen, Name
from harness.recorder.column import source_of
from harness.recorder.env_facts import versions_of
from harness.registry import Choice, Registry, choose, source_hash
from harness.registry.spec import blamed_on
from harness.robot.robot import load_robot
from harness.task import choose_task

from ..transitions.audit_rewards import GAMMA
from .arm_world import ArmWorld
from .environment_world import EnvironmentWorld
from .world import World

GAMMA_OF_ARM = 0.95
"""The discount of a learner on a task of an arm, where nobody says it; elsewhere it is `GAMMA`."""
OTHERS = ("mujoco", "pybullet", "kinematic")
"""Simulators that an arm's behaviour is tried in, the first that is installed and is another one."""
ENGINES = ("mujoco", "Box2D", "pybullet", "pymunk", "pygame", "brax", "jax", "torch")
"""Their versions are noted where an environment has imported them."""


Text = Annotated[str, StringConstraints(max_length=10_000)]
"""What a file may tell in words."""


@with_config(EXACT)
@dataclass(frozen=True)
class Place(Plain):
    """One reward in one task or environment.

    Attributes:
        task: The task of an arm, or the environment.
        reward: The reward.
        robot: The arm's name or path; empty in an environment.
        simulator: Whose engine moves the arm; None without one, and in an environment.
        success: What tells success, as a user types it; empty if nothing does.
        gamma: The learner's discount per step, in (0, 1].
        horizon: The most steps of an episode; 0 for the env's own limit.
        plugins: What ``--plugin`` has to give: path and SHA-256 of files, names of classes.
    """

    task: Chosen
    reward: Chosen
    robot: Text = ""
    simulator: Chosen | None = None
    success: Text = ""
    gamma: Annotated[float, Field(gt=0.0, le=1.0)] = GAMMA
    horizon: Annotated[int, Field(ge=1, le=10**9)] = 0
    plugins: Annotated[tuple[dict[Name, Text | bool], ...], Field(max_length=100)] = ()

    @property
    def is_environment(self) -> bool:
        """Whether it is an environment, and no task of an arm."""
        return not self.robot

    @property
    def name(self) -> str:
        """What it is called."""
        engine = f" in {self.simulator.label}" if self.simulator else ""
        return self.task.label if self.is_environment else f"{self.task.label}, {self.robot}{engine}"


def places_on_task(
    registry: Registry, rewards: Sequence[Choice], task: str, robot: str | None, sim: str | None, gamma: float
) -> list[Place]:
    """A place for each reward on an arm's task.

    Args:
        registry: The plugins.
        rewards: The rewards.
        task: The task, ``fd100-reach``.
        robot: The arm; None for the task's own.
        sim: The simulator; None for joints that move exactly as commanded.
        gamma: The learner's discount per step.

    Raises:
        UsageError: A name is not known.
    """
    chosen, _ = choose_task(registry, task, robot)
    arm = robot or str(chosen.build(registry, "tasks").robot)
    engine = choose(registry, "simulators", sim) if sim else None
    return [Place(chosen, it, arm, engine, gamma=gamma, plugins=needs_of(registry)) for it in rewards]


def places_in_environment(
    registry: Registry, environment: Choice, rewards: Sequence[str], gamma: float, success: str = ""
) -> list[Place]:
    """A place for each reward of an environment, of those that are named, or of all.

    Args:
        registry: The plugins.
        environment: The environment.
        rewards: Which of its rewards, ``hover``, ``hover:effort=2``; all if empty.
        gamma: The learner's discount per step.
        success: What tells success, as a user types it; empty to find a measure that does.

    Raises:
        UsageError: A name is not known.
    """
    looked = look_at(environment, registry)
    choices = dict.fromkeys(looked.rewards_asked(name, ())[0] for name in rewards or looked.rewards)
    return [Place(environment, it, success=success, gamma=gamma, plugins=needs_of(registry)) for it in choices]


def needs_of(registry: Registry) -> tuple[dict[str, Any], ...]:
    """What was given by hand; of files the name, for the folder that they lie in is nobody else's concern."""
    needs = [dict(it.need) for it in registry.given]
    return tuple({**need, "path": Path(str(need["path"])).name} if "path" in need else need for need in needs)


def blamed_at(place: Place, registry: Registry) -> AbstractContextManager[None]:
    """Whatever is raised in this block is said to be the environment's; on a task, the reward's."""
    kind, choice = ("environments", place.task) if place.is_environment else ("rewards", place.reward)
    return choice.blamed(registry, kind, "it was searched")


def elsewhere_of(place: Place, registry: Registry, names: Iterable[str] = OTHERS) -> dict[str, Callable[[], World]]:
    """By name, what makes the same in those other simulators of an arm that can be used; none of an environment."""
    there = [] if place.is_environment else usable(registry, "simulators")
    return {
        name: partial(world_at, replace(place, simulator=choose(registry, "simulators", name)), registry)
        for name in names
        if name in there and not (place.simulator and place.simulator.name == name)
    }


def called_here(place: Place, registry: Registry) -> Place:
    """A place with the labels that its names and parameters have here.

    Raises:
        UsageError: A name is not known.
    """
    given = {name: {"name": it.name, **it.named} for name, it in vars(place).items() if isinstance(it, Choice)}
    kinds = {"task": "environments"} if place.is_environment else {name: f"{name}s" for name in given}
    here: dict[str, Any] = {name: choose(registry, kind, given[name]) for name, kind in kinds.items()}
    if place.is_environment:
        here["reward"] = look_at(place.task, registry).rewards_asked(given["reward"], ())[0]
    return replace(place, **here)


def world_at(place: Place, registry: Registry) -> World:
    """A new world of a place.

    Raises:
        UsageError: A name in it is not known, or its reward fails.
        PluginError: A plugin behind a name is broken.
    """
    chosen = place.reward
    if place.is_environment:
        environment: Environment = place.task.build(registry, "environments")
        with blamed_at(place, registry):
            return EnvironmentWorld(
                environment.make(), environment.make, lambda env: columns_of(environment, env, registry, [chosen]),
                place.name, chosen.label, place.gamma, place.success, place.horizon or None,
            )  # fmt: skip
    return ArmWorld(arm_at(place, registry), place.name, chosen.label, place.gamma)


def arm_at(place: Place, registry: Registry) -> Arm:
    """What the simulator of an arm's place is opened with.

    Raises:
        UsageError: A name in it is not known.
        PluginError: A plugin behind a name is broken.
    """
    return Arm(
        place.simulator.build(registry, "simulators") if place.simulator else IdealSimulator(),
        load_robot(place.robot, registry),
        place.task.build(registry, "tasks"),
        place.reward.build(registry, "rewards"),
    )


def runs_on(place: Place, registry: Registry) -> dict[str, dict[str, Any]]:
    """Versions, machine, and SHA-256 of sources that decide what a behaviour is paid, as they are here.

    Raises:
        UsageError: A name is not known.
        PluginError: The environment cannot be made.
    """
    chosen = {"environments": place.task} if place.is_environment else {"tasks": place.task, "rewards": place.reward}
    if place.simulator is not None:
        chosen["simulators"] = place.simulator
    specs = {kind: registry.get(kind, choice.name) for kind, choice in chosen.items()}
    sources = {kind[:-1]: source_hash(spec.load()) for kind, spec in specs.items()}
    versions = {"python": platform.python_version(), **versions_behind(specs.values())}
    if place.is_environment:
        environment: Environment = place.task.build(registry, "environments")
        with blamed_on(specs["environments"], "an env was made"), closing(environment.make()) as env:
            columns = columns_of(environment, env, registry, [place.reward])
            sources["reward"] = source_of(columns.rewards[place.reward.label]).sha256
            versions |= versions_of(env, ENGINES)
    else:
        sources["robot"] = load_robot(place.robot, registry).digest
    machine = {key: value for key, value in describe_machine().items() if key != "cores"}
    return {"versions": versions, "machine": machine, "sources": {name: it for name, it in sources.items() if it}}
