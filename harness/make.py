"""From names to things: robots and environments."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

from gymnasium.vector import AutoresetMode

from harness.choice import Choice, choose
from harness.env import ReachVectorEnv
from harness.errors import UsageError
from harness.plugins import Registry, load_registry
from harness.robot import Robot, read_robot

Given: TypeAlias = str | Mapping[str, Any]
"""``"arp:k2=2"`` or ``{"name": "arp", "k2": 2}``."""


def load_robot(name_or_path: str | Path, registry: Registry | None = None) -> Robot:
    """A registered robot, or the one in a folder.

    Args:
        name_or_path: ``fd100``, or the path of a folder that holds ``robot.toml`` and the URDF it names.
        registry: The plugins; loaded if None.

    Raises:
        UsageError: No such robot, or its files say something that cannot be.
    """
    text = str(name_or_path)
    if isinstance(name_or_path, Path) or "/" in text or "\\" in text:
        if not Path(text).is_dir():
            raise UsageError(f"No robot folder '{text}': name a folder that holds robot.toml, or a registered robot")
        return read_robot(Path(text))
    folder: Path = (registry or load_registry()).get("robots", text).load()
    return read_robot(folder)


def make_env(
    simulator: Given = "mujoco",
    task: Given = "fd100-reach",
    reward: Given = "baseline",
    robot: str | Path = "fd100",
    num_envs: int = 1,
    autoreset_mode: AutoresetMode = AutoresetMode.SAME_STEP,
) -> ReachVectorEnv:
    """The vector env of one combination.

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
    registry: Registry, simulator: Choice, task: Choice, reward: Choice, robot: str | Path, **options: Any
) -> ReachVectorEnv:
    """The vector env of resolved choices; `options` go to `ReachVectorEnv`."""
    return ReachVectorEnv(
        simulator.build(registry, "simulators"),
        load_robot(robot, registry),
        task.build(registry, "tasks"),
        reward.build(registry, "rewards"),
        **options,
    )
