"""Explains what a name stands for, in plain text."""

import inspect
from collections.abc import Sequence
from typing import Any

import numpy as np

from harness.choice import choose
from harness.make import load_robot
from harness.parameters import parameters_of, values_of
from harness.plugins import Registry
from harness.robot import Robot
from harness.task import ReachTask


def describe_name(registry: Registry, kind: str, given: str, robot: str) -> str:
    """Summary, documentation and parameters of ``name:key=value`` of one kind; a task as its tuple.

    Raises:
        UsageError: Unknown or malformed; see `harness.choice.choose`.
    """
    if kind == "robots":
        return _describe_robot(load_robot(given, registry))
    choice = choose(registry, kind, given)
    spec, thing = registry.get(kind, choice.name), choice.build(registry, kind)
    parts = [f"{kind[:-1]} {choice.label}: {spec.summary} (plugin '{spec.plugin}' of {spec.distribution})"]
    parts.append(inspect.cleandoc(type(thing).__doc__ or ""))
    if isinstance(thing, ReachTask):
        parts.append(describe_task(thing, load_robot(robot, registry)))
    parts.append(_describe_parameters(type(thing), values_of(thing)))
    return "\n\n".join(part for part in parts if part)


def describe_task(task: ReachTask, robot: Robot) -> str:
    """The task on a robot as the NOTE's tuple <S, A, T, R>."""
    return "\n\n".join([_states(robot), _actions(task, robot), _transition(task, robot), _rewards(task)])


def _states(robot: Robot) -> str:
    dof, rows = robot.dof, []
    for j, (lower, upper) in enumerate(zip(np.degrees(robot.lower), np.degrees(robot.upper), strict=True), start=1):
        speed, acceleration = np.degrees(robot.max_speed[j - 1]), np.degrees(robot.max_acceleration[j - 1])
        rows.append((f"s_j{j}-angle", f"{lower:.4g} .. {upper:.4g} deg", "position in this range, -1 .. 1"))
        rows.append((f"s_j{j}-speed", f"at most {speed:.4g} deg/s", "fraction of it, -1 .. 1"))
        rows.append((f"s_j{j}-accel", f"at most {acceleration:.4g} deg/s^2", "fraction of it, -1 .. 1"))
    more = [
        ("target", "3 numbers", "world frame, m"),
        ("end effector", "3 numbers", "world frame, m"),
        ("offset", "3 numbers", "target - end effector, m"),
        ("distance", "1 number", "length of the offset, NOTE eq. 14, m"),
    ]
    head = (
        f"S, the state: {3 * dof} numbers of NOTE Table I and 10 that say where the target is. The observation holds "
        "all angles first, then all speeds, then all accelerations."
    )
    note = "Table I gives angles as 0 .. 350 deg; the published joint ranges differ and are used."
    return f"{head}\n{_table(rows + more)}\n{note if robot.name == 'fd100' else ''}".rstrip()


def _actions(task: ReachTask, robot: Robot) -> str:
    motion = task.motion(robot)
    rows = [
        (f"a_j{j}", "-1 .. 1", f"full action {np.degrees(speed):.4g} deg/s, changes by {np.degrees(change):.4g} a step")
        for j, (speed, change) in enumerate(zip(motion.max_speed, motion.max_change, strict=True), start=1)
    ]
    head = (
        f"A, the actions: MoveJ of NOTE Table II. One speed per joint, as a fraction of {task.speed:.0%} of its "
        f"maximum, reached with at most {task.acceleration:.0%} of its maximum acceleration; it brakes before the end "
        "of the joint's range."
    )
    return f"{head}\n{_table(rows)}"


def _transition(task: ReachTask, robot: Robot) -> str:
    home = ", ".join(f"{angle:.4g}" for angle in np.degrees(robot.home))
    rows = [
        ("step", f"{task.control_period:g} s at constant joint speeds, in the simulator's dynamics"),
        ("start", f"home ({home}) deg, each joint +- {np.degrees(task.start_noise):.3g} deg, from the seed"),
        ("target", f"uniform in the box {task.target_center} +- {task.target_half_extent} m where the arm reaches"),
        ("terminated", f"the end effector is within epsilon = {task.epsilon:g} m of the target (NOTE eq. 20)"),
        ("terminated", "a moving link touches the ground z = 0 (NOTE eq. 18)"),
        ("truncated", f"after {task.horizon} steps"),
    ]
    return f"T, the transition:\n{_table(rows)}"


def _rewards(task: ReachTask) -> str:
    rows = [
        ("shaped", "chosen with --reward; recorded apart from the events", ""),
        ("ground", f"{task.ground_reward:+g}", "NOTE eq. 18"),
        ("target", f"{task.target_reward:+g}", "NOTE eq. 19"),
        ("step", f"{task.step_reward:+g}", "the baseline's step penalty"),
    ]
    return f"R, the reward: the sum of\n{_table(rows)}"


def _describe_robot(robot: Robot) -> str:
    limits = zip(robot.joint_names, robot.lower, robot.upper, robot.max_speed, robot.max_acceleration, strict=True)
    rows = [
        (name, *(f"{np.degrees(value):.4g}" for value in (lower, upper, speed, acceleration)))
        for name, lower, upper, speed, acceleration in limits
    ]
    head = ("joint", "lower deg", "upper deg", "speed deg/s", "acceleration deg/s^2")
    tip = f"end effector {robot.end_effector_link}, reach {robot.reach:.3f} m, files in {robot.folder}"
    return f"robot {robot.name}: {robot.dof} joints, {tip}\n{_table([head, *rows])}"


def _describe_parameters(target: Any, values: dict[str, Any]) -> str:
    parameters = parameters_of(target)
    if not parameters:
        return "No parameters."
    rows = [
        (parameter.name, parameter.type, f"{values[parameter.name]}", parameter.description) for parameter in parameters
    ]
    return f"Parameters:\n{_table(rows)}"


def _table(rows: Sequence[Sequence[str]]) -> str:
    """Columns aligned, two blanks apart."""
    widths = [max(len(cell) for cell in column) for column in zip(*rows, strict=True)]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
    return "\n".join(f"  {line}".rstrip() for line in lines)
