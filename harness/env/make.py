"""From names to environments."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from harness.arrays import Float32
from harness.env.vector_env import ReachVectorEnv
from harness.errors import UsageError
from harness.record.cell import Cell
from harness.registry.choice import Choice, choose
from harness.registry.registry import Registry, load_registry
from harness.reward import Reward
from harness.robot import Robot
from harness.robot.robot import load_robot
from harness.simulator import Simulator
from harness.task import Task, choose_task

Given: TypeAlias = str | Mapping[str, Any]
"""``"arp:k2=2"`` or ``{"name": "arp", "k2": 2}``."""


@dataclass(frozen=True)
class World:
    """Everything that an environment is made of. It is built once and opened as often as needed.

    Attributes:
        simulator: Whose engine moves the arms.
        robot: The arm.
        task: What it has to do.
        reward: What it is paid for.
        records: What rows have beside the usual columns.
    """

    simulator: Simulator
    robot: Robot
    task: Task
    reward: Reward
    records: tuple[str, ...] = ()

    def open(self, num_envs: int, **options: Any) -> ReachVectorEnv:
        """An environment of `num_envs` arms; `options` go to `harness.env.ReachVectorEnv`."""
        return ReachVectorEnv(
            self.simulator, self.robot, self.task, self.reward, num_envs, records=self.records, **options
        )


def build_world(cell: Cell, robot: Robot, registry: Registry) -> World:
    """The world of a cell's episodes.

    Args:
        cell: Whose simulator, task and reward.
        robot: The cell's, loaded.
        registry: The plugins.

    Raises:
        UsageError: Something is not installed any more, or does not take its parameters.
    """
    return World(
        cell.simulator.build(registry, "simulators"),
        robot,
        cell.task.build(registry, "tasks"),
        cell.reward.build(registry, "rewards"),
        cell.records,
    )


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

    def build(kind: str, given: Given) -> Any:
        choice: Choice = choose(registry, kind, given)
        return choice.build(registry, kind)

    goal, arm = choose_task(registry, task, robot, partial(load_robot, registry=registry))
    world = World(build("simulators", simulator), arm, goal.build(registry, "tasks"), build("rewards", reward))
    return world.open(num_envs, autoreset_mode=autoreset_mode)


Action = NDArray[Any]


class ReachEnv(gymnasium.Env[Float32, Action]):
    """A `ReachVectorEnv` of one env, without its leading axis."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012 (Gymnasium declares it so)

    def __init__(
        self,
        simulator: Given = "mujoco",
        task: Given = "fd100-reach",
        reward: Given = "baseline",
        robot: str | Path | None = None,
        render_mode: str | None = None,
    ) -> None:
        if render_mode not in {None, *self.metadata["render_modes"]}:
            raise UsageError(
                f"render_mode {render_mode!r}: the env itself draws 'rgb_array' or nothing. "
                "gymnasium.make(..., render_mode='human') opens a window around it, which takes "
                "pip install 'gymnasium[classic-control]'"
            )
        self.vector_env = make_env(simulator, task, reward, robot, autoreset_mode=AutoresetMode.DISABLED)
        self.observation_space = self.vector_env.single_observation_space
        self.action_space = self.vector_env.single_action_space
        self.render_mode = render_mode

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Float32, dict[str, Any]]:
        """Start an episode; see `ReachVectorEnv.reset`."""
        super().reset(seed=seed)
        observations, infos = self.vector_env.reset(seed=seed, options=options)
        return observations[0], _first(infos)

    def step(self, action: Action) -> tuple[Float32, float, bool, bool, dict[str, Any]]:
        """One control period; see `ReachVectorEnv.step`."""
        observations, rewards, terminated, truncated, infos = self.vector_env.step(np.asarray(action)[None])
        return observations[0], float(rewards[0]), bool(terminated[0]), bool(truncated[0]), _first(infos)

    def render(self) -> NDArray[np.uint8] | None:
        """One RGB frame, (480, 640, 3), in the render mode ``rgb_array``."""
        return self.vector_env.render()[0] if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """Close the simulator."""
        self.vector_env.close()


def _first(infos: dict[str, Any]) -> dict[str, Any]:
    return {key: values[0].item() for key, values in infos.items()}
