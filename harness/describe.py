"""Explains what a name stands for, in plain text."""

import inspect
import json
import math
import re
import tempfile
from collections.abc import Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any, get_args

import numpy as np

from harness.algorithm import IN_ENVIRONMENTS
from harness.conditions.conditions import Conditions, conditions_of
from harness.env.arm_observation import ArmObservation, GoalObservation
from harness.environment import Environment
from harness.errors import HarnessError, UsageError
from harness.hookspecs import NOUNS
from harness.log import LogFormat
from harness.log.measure import Measure, needs_of as measure_needs
from harness.motion.discrete import Discrete
from harness.motion.modes import MODES
from harness.motion.motion import MoveJ
from harness.registry.choice import Registry, choose, parse
from harness.registry.members import Parameter, parameters_of, values_of
from harness.registry.spec import Spec, blamed_on
from harness.registry.step_functions import WHAT_ONE_TAKES
from harness.reward import Reward
from harness.reward.steps import ARM, ENVIRONMENT, MissingField
from harness.reward.terms import needs_of
from harness.robot import Robot
from harness.robot.chain_end import tip_of
from harness.robot.joint_limits import Part
from harness.robot.robot import load_robot
from harness.robot.settings import FILE, SERVO
from harness.simulator import family_of
from harness.task import Task, choose_task, goal_of

OF_ENVIRONMENTS = {field.name for field in ENVIRONMENT} - {field.name for field in ARM}
"""Fields of steps of environments that steps of an arm do not have."""
SHOWN_LINKS = 6
"""Links beside the end effector that are named; a hand has dozens."""
SOURCES = "NOTE and ARP are the sources that docs/sources.md names."


def describe_name(registry: Registry, kind: str, given: str, robot: str | None) -> str:
    """Summary, documentation and parameters of ``name:key=value`` of one kind; a task as its tuple.

    Raises:
        UsageError: Unknown or malformed; see `harness.registry.choice.choose`.
    """
    if kind == "robots":
        return _describe_robot(load_robot(given, registry))
    if kind == "commands":
        command = registry.get(kind, given)
        return f"command {given}: {command.summary} (plugin '{command.plugin}' of {command.package})"
    name, params = parse(given)
    spec = registry.get(kind, name)
    if not (params or spec.missing or all(it.has_default for it in parameters_of(spec.load()))):
        # nothing can be built of the bare name
        parts = [*_head(spec, name, spec.load()), _describe_parameters(spec.load(), {})]
    else:
        load = partial(load_robot, registry=registry)
        choice, arm = (
            choose_task(registry, given, robot, load) if kind == "tasks" else (choose(registry, kind, given), None)
        )
        thing = choice.build(registry, kind)
        parts = _head(spec, choice.label, type(thing))
        if kind == "simulators":
            parts.append(_describe_family(thing))
        if kind == "rewards":
            parts.append(_describe_reading(thing))
        if kind == "metrics":
            parts.append(_describe_measure(thing))
        if kind == "environments":
            parts.append(_describe_env(thing, spec))
        if kind == "logs":
            parts.append(_describe_format(thing, spec))
        if arm is not None:
            parts += [describe_task(thing, arm), _steps_of_arms()]
        parts.append(_describe_parameters(type(thing), values_of(thing)))
        if kind == "algorithms":
            parts.append(_describe_in_environments(choice.label, choose(registry, kind, given, IN_ENVIRONMENTS).label))
    own = next((it.own for it in registry.plugins if it.name == spec.plugin), ())
    parts.append(f"{spec.plugin} also has {', '.join(own)}: {WHAT_ONE_TAKES}" if own else "")
    told = "\n\n".join(part for part in parts if part)
    return f"{told}\n\n{SOURCES}" if re.search(r"\b(NOTE|ARP)\b", told) else told


def _describe_reading(reward: Reward) -> str:
    """What a reward reads and pays, found by one call, and what it could read."""
    try:
        found = needs_of(reward)
    except MissingField as error:
        if error.field.rpartition(".")[2] in OF_ENVIRONMENTS:
            return (
                f"It reads step.{error.field}: it pays steps of environments, and no arm. `harness describe "
                "gymnasium:id=NAME` prints what these have."
            )
        raise
    except UsageError as error:  # one that needs an arm of its own, or real steps
        return f"What it reads is not known: {error}"
    terms = f"It pays the sum of its terms: {', '.join(found.terms)}.\n" if found.terms else ""
    reads = ", ".join(f"step.{name}" for name in found.fields) or "nothing of a step"
    return f"{terms}It reads {reads}.\n\n{_steps_of_arms()}"


def _describe_measure(measure: Measure) -> str:
    """In which direction a measure is better, its unit, and what it says that it reads."""
    unit = f", in {measure.unit}" if measure.unit else ""
    reads = ", ".join(f"step.{name}" for name in sorted(measure_needs(measure)))
    return f"{measure.better.capitalize()} is better{unit}.{f' It reads {reads}.' if reads else ''}"


def _steps_of_arms() -> str:
    """The table of what a reward may read of an arm."""
    rows = [(it.name, f"{it.shape} {it.unit}".strip(), f"{it.told}{' (b)' * it.before}") for it in ARM]
    head = "What a reward may read of a step of num_envs arms; (b): also of what was before, as step.before.action:"
    return f"{head}\n{_table(rows)}"


def _describe_env(environment: Environment, spec: Spec) -> str:
    """What a reward may read of a step of an env: one is made, reset and stepped once."""
    try:
        with blamed_on(spec, "an env was tried"), closing(environment.make()) as env:
            env.reset(seed=0)
            env.action_space.seed(0)
            *_, info = env.step(env.action_space.sample())
            spaces = str(env.observation_space), str(env.action_space)
    except HarnessError as error:
        return f"What a reward may read is not known: {error}"
    rows = [
        ("observation", spaces[0], "what the env observed after the step (b)"),
        ("action", spaces[1], "what the policy did (b)"),
        ("info", ", ".join(map(str, info)) or "no key", "keys that the env told in its first step (b)"),
    ]
    return f"What a reward may read of a step; (b): also of what was before, as step.before.action:\n{_table(rows)}"


def _describe_format(reader: LogFormat, spec: Spec) -> str:
    """What a row of its logs is, and the columns: those of the example that it writes."""
    try:
        with blamed_on(spec, "its example was read"), tempfile.TemporaryDirectory() as folder:
            logs = reader.read(reader.write_example(Path(folder)))
            units = {log.facts.unit: log.names for log in logs}
    except HarnessError as error:
        return f"What it reads is not known: {error}"
    rows = (f"A row is {'an' if unit == 'episode' else 'a'} {unit}. Its example has the columns" for unit in units)
    return "\n".join(f"{row} {', '.join(names)}." for row, names in zip(rows, units.values(), strict=True))


def _head(spec: Spec, label: str, target: Any) -> list[str]:
    """Who brings it, and what its docstring says."""
    text = inspect.cleandoc(target.__doc__ or "")
    # A plugin in a file has its docstring's first line for a summary.
    told = [text] if text != spec.summary else []
    return [f"{NOUNS[spec.kind]} {label}: {spec.summary} (plugin '{spec.plugin}' of {spec.package})", *told]


def describe_task(task: Task, robot: Robot) -> str:
    """The task on a robot as the NOTE's tuple <S, A, T, R>."""
    return "\n\n".join([_states(task, robot), _actions(task, robot), _transition(task, robot), _rewards(task)])


def _states(task: Task, robot: Robot) -> str:
    observation = task.observation(robot)
    head = f"S, the state: {len(observation.low)} numbers."
    if not isinstance(observation, ArmObservation):
        return f"{head} {inspect.cleandoc(type(observation).__doc__ or '')}"
    note = "\nTable I gives angles as 0 .. 350 deg; the published joint ranges differ and are used."
    return (
        f"{head} NOTE Table I for each joint, and where the target is; all angles stand first, then all speeds, then "
        f"all accelerations.\n{_table([*_arm_states(robot), *_goal_states(observation), *_obstacles(observation)])}"
        f"{note if robot.name == 'fd100' else ''}"
    )


def _arm_states(robot: Robot) -> list[tuple[str, str, str]]:
    rows = []
    for j, (lower, upper) in enumerate(zip(robot.lower, robot.upper, strict=True)):
        scale, unit = _unit_of(robot, j)
        speed, acceleration = robot.max_speed[j] * scale, robot.max_acceleration[j] * scale
        span = f"{lower * scale:.4g} .. {upper * scale:.4g} {unit}"
        rows.append((f"s_j{j + 1}-angle", span, "position in this range, -1 .. 1"))
        rows.append((f"s_j{j + 1}-speed", f"at most {speed:.4g} {unit}/s", "fraction of it, -1 .. 1"))
        rows.append((f"s_j{j + 1}-accel", f"at most {acceleration:.4g} {unit}/s^2", "fraction of it, -1 .. 1"))
    return [
        *rows,
        ("target", "3 numbers", "world frame, m"),
        ("end effector", "3 numbers", "world frame, m"),
        ("offset", "3 numbers", "target - end effector, m"),
    ]


def _goal_states(observation: ArmObservation) -> list[tuple[str, str, str]]:
    """How far the target is, and what else is asked for."""
    if not isinstance(observation, GoalObservation):
        return [("distance", "1 number", "length of the offset, NOTE eq. 14, m")]
    goal, count = observation.goal, len(observation.goal.bounds()[0])
    more = [("goal", f"{count} number{'s' * (count > 1)}", goal.observed)] if count else []
    return [("error", "1 number", f"the {goal.error}, {goal.unit or 'without a unit'}"), *more]


def _obstacles(observation: ArmObservation) -> list[tuple[str, str, str]]:
    """What is seen of obstacles, if anything."""
    count = observation.obstacles
    return [("obstacles", f"{count} x 7 numbers", "centre - end effector, half edges, radius, m")] * bool(count)


def _unit_of(robot: Robot, joint: int) -> tuple[float, str]:
    """What a position of this joint is shown in: the factor, and the unit."""
    return (1.0, "m") if robot.chain.slides[joint] else (math.degrees(1.0), "deg")


def _actions(task: Task, robot: Robot) -> str:
    motion = task.motion(robot)
    if not isinstance(motion, MoveJ):
        count = f"{motion.choices} choices" if isinstance(motion, Discrete) else f"{motion.action_size} numbers"
        mode = MODES[parse(task.action)[0]]
        return f"A, the actions: {count}, mode {task.action} of NOTE Table II. {inspect.cleandoc(mode.__doc__ or '')}"
    rows = []
    for j, (speed, change) in enumerate(zip(motion.limits.max_speed, motion.limits.max_change, strict=True)):
        scale, unit = _unit_of(robot, j)
        full = f"full action {speed * scale:.4g} {unit}/s, changes by {change * scale:.4g} a step"
        rows.append((f"a_j{j + 1}", "-1 .. 1", full))
    head = (
        f"A, the actions: MoveJ of NOTE Table II. One speed per joint, as a fraction of {task.speed:.0%} of its "
        f"maximum, reached with at most {task.acceleration:.0%} of its maximum acceleration; it brakes before the end "
        "of the joint's range."
    )
    return f"{head}\n{_table(rows)}"


def _transition(task: Task, robot: Robot) -> str:
    goal = goal_of(task, robot)
    reached = f"the end effector is within epsilon = {task.epsilon:g} m of the target (NOTE eq. 20)"
    if goal is not None:
        steps = f" for {goal.steps_within} steps in a row" if goal.steps_within > 1 else ""
        reached = f"the {goal.error} is at most epsilon = {task.epsilon:g} {goal.unit}".rstrip() + steps
    decision = f"{task.decision_period} steps under one action, a reward on each"
    rows = [
        ("step", f"{task.control_period:g} s, in the simulator's dynamics unless the action sets the joints"),
        *([("decision", decision)] if task.decision_period > 1 else []),
        ("start", task.start_in_words(robot)),
        ("target", task.target_in_words(robot)),
        ("terminated" if task.ends_at_target else "next target", reached),
        ("terminated", "a moving link touches the ground z = 0 (NOTE eq. 18)"),
        *_conditions(conditions_of(task)),
        ("truncated", f"after {task.horizon} steps"),
    ]
    return f"T, the transition:\n{_table(rows)}"


def _conditions(told: Conditions) -> list[tuple[str, str]]:
    """What there is of noise, delays, obstacles and varied arms."""
    seen, count = (told.joint_noise, told.speed_noise, told.target_noise), told.most_obstacles
    varied = (
        ("masses of links", told.mass_variation),
        ("sizes of links", told.length_variation),
        ("friction of drives", told.friction_variation),
    )
    arms = ", ".join(f"{name} +- {share:.0%}" for name, share in varied if share)
    rows = [
        (
            any(seen),
            "noise",
            "standard deviation of what is seen: {:.3g} rad, {:.3g} rad/s, target {:.3g} m".format(*seen),
        ),
        (told.action_noise, "noise", f"standard deviation of what is done: {told.action_noise:.3g} of a full action"),
        (told.observation_delay, "delay", f"what is seen is {told.observation_delay} steps old"),
        (told.action_delay, "delay", f"an action works {told.action_delay} steps later"),
        (count, "obstacles", f"{count} at most; the arm touches one at {told.obstacle_clearance:g} m"),
        (count, "terminated", "a moving link touches an obstacle"),
        (told.is_varied, "arm", f"one of {told.variants}, drawn for each episode, {arms}"),
    ]
    return [(name, text) for is_there, name, text in rows if is_there]


def _rewards(task: Task) -> str:
    task_goes_on, told = not task.ends_at_target, conditions_of(task)
    rows = [
        ("shaped", "chosen with --reward; recorded apart from the events", ""),
        ("ground", f"{task.ground_reward:+g}", "NOTE eq. 18"),
        *[("obstacle", f"{told.obstacle_reward:+g}", "recorded with the ground's")] * bool(told.most_obstacles),
        ("target", task.target_reward_in_words(), "NOTE eq. 19" + " differs: +1, and the episode ends" * task_goes_on),
        ("step", f"{task.step_reward:+g}", "the baseline's step penalty"),
    ]
    return f"R, the reward: the sum of\n{_table(rows)}"


def _describe_family(simulator: Any) -> str:
    family = family_of(simulator)
    return f"Engine: {family}. Simulators of one engine count as one." if family else "Engine: none."


def _describe_robot(robot: Robot) -> str:
    columns = robot.lower, robot.upper, robot.home, robot.max_speed, robot.max_acceleration
    scales = np.where(robot.chain.slides, 1.0, np.degrees(1.0))
    rows = [
        (name, kind, *(f"{number:.4g}" for number in numbers), "m" if kind == "prismatic" else "deg")
        for name, kind, numbers in zip(
            robot.joint_names, robot.chain.kinds, (np.array(columns) * scales).T, strict=True
        )
    ]
    head = ("joint", "type", "lower", "upper", "home", "speed /s", "acceleration /s^2", "unit")
    tip = f"end effector {robot.end_effector_link}, reach {robot.reach:.3f} m, files in {robot.folder}"
    origins = [(f"{quantity.replace('_', ' ')}:", origin) for quantity, origin in robot.origins.items()]
    told = f"robot {robot.name}: {robot.dof} joints, {tip}\n{_table([head, *rows])}\n\nFrom\n{_table(origins)}"
    warnings = [f"Note: {line}" for line in robot.warnings]
    return "\n\n".join([told, _describe_tip(robot), *warnings, _describe_drives(robot)])


def _describe_tip(robot: Robot) -> str:
    """The link that has to reach targets, and those that might be meant by it."""
    tip = tip_of(robot.urdf, robot.end_effector_link, robot.chain)
    more = f" and {len(tip.beside) - SHOWN_LINKS} more" * (len(tip.beside) > SHOWN_LINKS)
    lines = [
        f"Targets are for the origin of link {robot.end_effector_link}.",
        f"It lies on the axis of {', '.join(tip.still)}, which cannot move it." if tip.still else "",
        f"Links beside it: {', '.join(tip.beside[:SHOWN_LINKS])}{more}." if tip.beside else "",
        f"If the tool is meant, write into {FILE}: end_effector = {json.dumps(tip.tool)}" if tip.tool else "",
    ]
    return "\n".join(line for line in lines if line)


def _describe_drives(robot: Robot) -> str:
    """The drives of simulators with drive=servo, in N m, or N where a joint slides, rad or m, kg, m and s."""
    servo = robot.servo
    if servo is None:
        return f"No drives for drive=servo: {FILE} has no table [{SERVO}]."
    parts = get_args(Part)
    numbers = np.array([getattr(servo, part) for part in parts]).T
    rows = [
        (name, *(f"{number:g}" for number in values)) for name, values in zip(robot.joint_names, numbers, strict=True)
    ]
    head = ("joint", *(part.replace("_", " ") for part in parts))
    weight = "compensated" if servo.gravity_compensated else "not compensated"
    told = f"Drives for drive=servo, in N m, rad, kg m^2 and s, where a joint slides in N, m, kg and s; {FILE}"
    return f"{told}\n{_table([head, *rows])}\n  latency {servo.latency:g} s, weight {weight}"


def _describe_in_environments(on_arm: str, elsewhere: str) -> str:
    """What else an algorithm's name stands for in somebody's environment; empty if it is the same."""
    return f"In an environment, {on_arm} stands for {elsewhere}." if on_arm != elsewhere else ""


def _default(parameter: Parameter) -> Any:
    return parameter.default if parameter.has_default else "has to be given"


def _describe_parameters(target: Any, values: dict[str, Any]) -> str:
    later = getattr(target, "later", ())
    parameters = sorted(parameters_of(target), key=lambda parameter: parameter.name in later)
    if not parameters:
        return "No parameters."
    rows = [
        (parameter.name, parameter.type, f"{values.get(parameter.name, _default(parameter))}", parameter.description)
        for parameter in parameters
    ]
    return f"Parameters:\n{_table(rows)}"


def _table(rows: Sequence[Sequence[str]]) -> str:
    """Columns aligned, two blanks apart."""
    widths = [max(len(cell) for cell in column) for column in zip(*rows, strict=True)]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
    return "\n".join(f"  {line}".rstrip() for line in lines)
