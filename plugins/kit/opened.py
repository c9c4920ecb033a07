"""A simulator, and a cell, from names: what the fixtures of `harness_plugins.kit.pytest_plugin` give."""

from collections.abc import Callable
from itertools import cycle
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from harness import load_robot
from harness.authoring.closed_motion import closed_motion
from harness.errors import UsageError
from harness.executor import Job, run_job
from harness.experiment.plan import check_experiment, expand
from harness.record import Manifest
from harness.registry import choose, load_registry
from harness.robot import Robot
from harness.simulator import Simulation


class Opened(NamedTuple):
    """A simulation, and what it was opened with."""

    simulation: Simulation
    robot: Robot
    num_envs: int
    period: float
    """Control period, [s]."""


def open_simulation(
    name: str, robot: str | None, num_envs: int, *, task: str = "fd100-reach", period: float | None = None
) -> Opened:
    """Open a simulator by name.

    Args:
        name: Of the simulator, with its parameters.
        robot: Its name or path; None: the task's.
        num_envs: How many arms.
        task: Whose robot and control period are taken where these are not given.
        period: Control period, [s]; None: the task's.

    Raises:
        UsageError: A name or a parameter is not known, or `num_envs` is below 1.
    """
    if num_envs < 1:
        raise UsageError(f"num_envs={num_envs}: must be at least 1")
    registry = load_registry()
    goal = choose(registry, "tasks", task).build(registry, "tasks")
    arm, seconds = load_robot(robot or goal.robot, registry), period or goal.control_period
    simulator = choose(registry, "simulators", name).build(registry, "simulators")
    return Opened(simulator.open(arm, num_envs, seconds), arm, num_envs, seconds)


def driven(opened: Opened) -> Callable[[], object]:
    """A function that drives all arms for one control period, along a small closed motion."""
    simulation, robot, num_envs, period = opened
    simulation.reset(np.tile(robot.home, (num_envs, 1)), np.ones(num_envs, bool))
    targets, drive = cycle(closed_motion(robot, num_envs)), simulation.drive
    return lambda: drive(next(targets), period)


def train_cell(folder: Path, **given: Any) -> tuple[Path, Manifest]:
    """Train and evaluate one cell in this process, under one reward.

    Args:
        folder: To leave.
        given: ``sim``, ``algo``, ``reward``, ``task``, ``robot``, ``steps``, ``evaluation_episodes``.

    Returns:
        The folder, and what its manifest says.

    Raises:
        UsageError: A name is not known, or they cannot do it together.
    """
    settings = {key: value for key, value in given.items() if value is not None}
    settings |= {"baseline": settings.pop("reward"), "reward": [], "seeds": [0]}
    plan = expand(check_experiment(settings, "the marker"), load_registry())
    if not plan.cells:
        raise UsageError(plan.skipped[0][1])
    return folder, run_job(Job(plan.cells[0], folder))
