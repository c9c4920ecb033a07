"""What the goal of a task must satisfy. Each check takes the task and a robot; a task without a goal passes all."""

import math
from typing import Any

import numpy as np

from harness.arrays import Float, Mask
from harness.authoring import reach_position
from harness.authoring.checking import IdealSimulator, reach_pose, rotation_of_axes
from harness.env import ReachVectorEnv
from harness.goal import Goal, Situation
from harness.robot import Robot
from harness.task import Task, goal_of

from .contract import Check, check, require
from .trainings import NegativeDistance

COUNT = 16
SEARCHES = 8
"""Poses from which one that does what is asked is searched."""
POLISHED = 8
"""Situations in which a search of its own looks for one where no kinematics know the way: it takes long."""
EXACT = 1e-5
"""The tolerance of an error in its unit: rounding, and what is left of a search."""
AIMS = ("position", "pose", None)
DECISIONS, LONGEST = 150, 1_200
"""The decisions that are made in random episodes at least, and at most: a whole episode of any built-in task has no
more."""


@check("task-goal-words")
def goals_are_described(task: Task, robot: Robot) -> None:
    """A goal's error has a name and a unit, one line each; its numbers, steps and bounds have the right form."""
    goal = goal_of(task, robot)
    if goal is None:
        return
    for name, text in (("error", goal.error), ("unit", goal.unit), ("observed", goal.observed)):
        require(isinstance(text, str) and "\n" not in text, f"{name} of the goal is {text!r}, not one line of text")
    require(goal.error, "error of the goal is empty: say in a few words what the number is")
    for name, count, least in (("numbers", goal.numbers, 0), ("steps_within", goal.steps_within, 1)):
        require(isinstance(count, int) and count >= least, f"{name} is {count!r}, not a whole number >= {least}")
    require(goal.aim in AIMS, f"aim is {goal.aim!r}: there is 'position', 'pose' and None")
    low, high = goal.bounds()
    require(low.shape == high.shape == (len(low),), f"the goal's bounds are {low.shape} and {high.shape}")
    require((low < high).all(), f"no number is between the goal's bounds {low} and {high}")
    require(bool(goal.observed) or not len(low), f"the goal shows {len(low)} numbers, and observed does not say which")


@check("task-error")
def errors_are_numbers(task: Task, robot: Robot) -> None:
    """The error is (n,), float64, finite and >= 0. Two calls give the same, and each arm has its own."""
    goal = goal_of(task, robot)
    if goal is None:
        return
    now = situations(task, robot, goal)
    before = [part.copy() for part in now]
    errors = goal.errors(now)
    require(isinstance(errors, np.ndarray), f"the errors are a {type(errors).__name__}, not an array")
    right = errors.shape == (COUNT,) and errors.dtype == np.float64
    require(right, f"the errors are {errors.dtype} {errors.shape}, not float64 ({COUNT},)")
    require(np.isfinite(errors).all() and (errors >= 0.0).all(), f"an error is no number >= 0: {errors}")
    require(np.array_equal(errors, goal.errors(now)), "the same situation gave two errors")
    require(all(map(np.array_equal, before, now)), "measuring the error changed the situation")
    alone = np.concatenate([goal.errors(Situation(*(part[k : k + 1] for part in now))) for k in range(COUNT)])
    require(np.allclose(errors, alone, rtol=1e-9, atol=1e-12), "an arm's error depends on the arms beside it")


@check("task-error-zero")
def errors_are_zero_at_the_goal(task: Task, robot: Robot) -> None:
    """Where the kinematics can solve the task, the error is 0 at the solution, and nowhere else within reach."""
    goal = goal_of(task, robot)
    if goal is None or goal.aim is None:
        return
    now = situations(task, robot, goal)
    qpos, found = _pose_at(robot, goal, now, robot.home)
    at = now._replace(qpos=qpos, end_effector=np.where(found[:, None], now.target, robot.end_effector(qpos)))
    errors = goal.errors(at)[found]
    require((errors <= EXACT).all(), f"at the goal the error is {errors.max(initial=0.0):.3g} {goal.unit}, not 0")
    away = goal.errors(now)
    require(
        (away > EXACT).all(),
        f"arms that were put anywhere have the error {away.min():.3g} {goal.unit}: they are not there",
    )


@check("task-goal-motion")
def targets_move_from_where_they_are_set(task: Task, robot: Robot) -> None:
    """A target moves by (n, 3), finite, from 0 at step 0, and by the same in every call; one that stays moves by 0."""
    goal = goal_of(task, robot)
    if goal is None:
        return
    now = situations(task, robot, goal)
    low = now.target[now.target[:, 2] < 0.0]
    require(not len(low), f"a target moves under the ground z = 0, as to {low[:1]} m: nothing can get there")
    for step in (np.zeros(COUNT), now.step):
        moved = goal.displacement(now.numbers, step)
        require(moved.shape == (COUNT, 3) and np.isfinite(moved).all(), f"a displacement is {moved.shape}: {moved}")
        require(np.array_equal(moved, goal.displacement(now.numbers, step)), "a target moves differently each time")
        may = goal.moves and step.any()
        require(
            may or not moved.any(),
            f"a target has moved by {moved[moved.any(axis=1)][:1]} m: at step 0, or with moves=False",
        )


@check("task-goal-observed")
def goals_show_numbers_in_their_bounds(task: Task, robot: Robot) -> None:
    """What a goal shows the learner is (n, size), finite, and within its bounds, in random episodes."""
    goal = goal_of(task, robot)
    if goal is None:
        return
    low, high = goal.bounds()
    env = ReachVectorEnv(IdealSimulator(), robot, task, NegativeDistance(), 3)
    env.action_space.seed(0)
    env.reset(seed=0)
    for _ in range(decisions_of(task)):
        env.step(env.action_space.sample())
        seen = goal.observe(env.episodes.situation)
        require(seen.shape == (3, len(low)), f"observe gives {seen.shape} for 3 arms and {len(low)} bounds")
        inside = (seen >= low - 1e-9).all() and (seen <= high + 1e-9).all()  # False of what is no number
        require(inside, "what the goal shows leaves its bounds {} .. {}: {}", low, high, seen)


GOAL_CHECKS: tuple[Check, ...] = (
    goals_are_described,
    errors_are_numbers,
    errors_are_zero_at_the_goal,
    targets_move_from_where_they_are_set,
    goals_show_numbers_in_their_bounds,
)


def decisions_of(task: Task) -> int:
    """The decisions of the longest episode and a fifth more, so that its end is seen; at least 150, at most 1,200."""
    return min(max(DECISIONS, math.ceil(1.2 * task.horizon / task.decision_period)), LONGEST)


def situations(task: Task, robot: Robot, goal: Goal, count: int = COUNT) -> Situation:
    """Arms anywhere in their ranges, `count` of them, some steps after they got their targets."""
    rng = np.random.default_rng(0)
    starts = np.array([task.draw_start(robot, rng) for _ in range(count)])
    position, relative = task.draw_targets(robot, rng, count)
    numbers = goal.draw(rng, position)
    step = rng.integers(0, task.horizon, count).astype(np.float64)
    target = np.where(relative[:, None], robot.end_effector(starts) + position, position)
    if goal.moves:
        target = target + goal.displacement(numbers, step)
    qpos = rng.uniform(robot.lower, robot.upper, (count, robot.dof))
    return Situation(qpos, robot.end_effector(qpos), target, numbers, step, np.zeros(count))


def are_met(task: Task, robot: Robot, goal: Goal, now: Situation) -> Mask:
    """Whether joint positions are found at which the error is within epsilon, (n,).

    Where no kinematics know the way, a slow search tries `POLISHED` of those that are left; the others count as met.
    """
    rng, best, least = np.random.default_rng(0), now.qpos.copy(), np.full(len(now.step), np.inf)
    starts: Any = robot.home
    for _ in range(1 + SEARCHES):
        qpos, _ = _pose_at(robot, goal, now, starts)
        errors = _errors_at(robot, goal, now, qpos)
        best, least = np.where((errors < least)[:, None], qpos, best), np.minimum(errors, least)
        if (least <= task.epsilon).all():
            break
        starts = rng.uniform(robot.lower, robot.upper, now.qpos.shape)
    met: Mask = least <= task.epsilon
    if goal.aim is not None:
        return met
    left = np.flatnonzero(~met)
    met[left[POLISHED:]] = True
    for k in left[:POLISHED]:
        met[k] = _polished(robot, goal, Situation(*(part[k : k + 1] for part in now)), best[k]) <= task.epsilon
    return met


def _pose_at(robot: Robot, goal: Goal, now: Situation, start: Float) -> tuple[Float, Mask]:
    """Joint positions at the targets, in their orientation where that is asked for, and whether they are there."""
    starts = np.broadcast_to(start, now.qpos.shape)
    if goal.aim != "pose":
        return reach_position(robot, now.target, starts, tolerance=1e-6, iterations=100)
    rotation = rotation_of_axes(goal.observe(now)[:, :6])
    return reach_pose(robot, now.target, rotation, starts, EXACT / 10, EXACT / 10, 200)


def _errors_at(robot: Robot, goal: Goal, now: Situation, qpos: Float) -> Float:
    return goal.errors(now._replace(qpos=qpos, end_effector=robot.end_effector(qpos)))


def _polished(robot: Robot, goal: Goal, now: Situation, start: Float) -> float:
    """The least error that a search finds which knows nothing of the goal, in one situation."""
    from scipy.optimize import minimize

    def error(qpos: Float) -> float:
        return float(_errors_at(robot, goal, now, np.clip(qpos, robot.lower, robot.upper)[None])[0])

    options = {"maxiter": 1000, "adaptive": True, "initial_simplex": start + 0.2 * np.eye(robot.dof + 1, robot.dof)}
    return float(minimize(error, start, method="Nelder-Mead", options=options).fun)
