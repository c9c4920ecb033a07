"""From names to environments."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

from gymnasium.vector import AutoresetMode

from harness.env.vector_env import ReachVectorEnv
from harness.errors import UsageError
from harness.registry.choice import Choice, choose
from harness.registry.registry import Registry, load_registry
from harness.robot.load import load_robot
from harness.task import Task

Given: TypeAlias = str | Mapping[str, Any]
"""``"arp:k2=2"`` or ``{"name": "arp", "k2": 2}``."""


def make_env(
    simulator: Given = "mujoco",
    task: Given = "fd100-reach",
    reward: Given = "baseline",
    robot: str | Path | None = None,
    num_envs: int = 1,
    autoreset_mode: AutoresetMode = AutoresetMode.SAME_STEP,
) -> ReachVectorEnv:
    """The vector env of one combination; the robot is by default the one that the task was made for.

    Raises:
        UsageError: A name or a parameter is not known.
    """
    if num_envs < 1:
        raise UsageError(f"num_envs={num_envs}: must be at least 1")
    registry = load_registry()
    return build_env(
        registry,
        choose(registry, "simulators", simulator),
        choose(registry, "tasks", task),
        choose(registry, "rewards", reward),
        robot,
        num_envs=num_envs,
        autoreset_mode=autoreset_mode,
    )


def build_env(
    registry: Registry, simulator: Choice, task: Choice, reward: Choice, robot: str | Path | None = None, **options: Any
) -> ReachVectorEnv:
    """The vector env of resolved choices; `options` go to `ReachVectorEnv`."""
    built: Task = task.build(registry, "tasks")
    return ReachVectorEnv(
        simulator.build(registry, "simulators"),
        load_robot(robot or built.robot, registry),
        built,
        reward.build(registry, "rewards"),
        **options,
    )
