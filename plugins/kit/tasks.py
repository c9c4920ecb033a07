"""What a task must satisfy. Each check takes the task and a robot."""

import math
from typing import Any

import numpy as np

from harness import Float, Float32, Mask, load_robot
from harness.env.ideal import IdealSimulator
from harness.env.vector_env import ReachVectorEnv
from harness.goal import Goal, Situation
from harness.robot import Robot, rotation_of_axes
from harness.robot.kinematics import reach_pose, reach_position
from harness.task import Task, goal_of, varies

from .contract import check, require, settings_are_frozen, settings_survive_json
from .trainings import NegativeDistance

COUNT = 16
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
    env = _env(task, robot)
    env.action_space.seed(0)
    env.reset(seed=0)
    for _ in range(decisions_of(task)):
        env.step(env.action_space.sample())
        seen = goal.observe(env.episodes.situation)
        require(seen.shape == (3, len(low)), f"observe gives {seen.shape} for 3 arms and {len(low)} bounds")
        inside = (seen >= low - 1e-9).all() and (seen <= high + 1e-9).all()  # False of what is no number
        require(inside, "what the goal shows leaves its bounds {} .. {}: {}", low, high, seen)


GOAL_CHECKS = (
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


DRAWS = 50
TARGETS = 128
MOST_MISSED = 0.05
"""Share of the targets that may be out of reach; a search that finds no pose is no proof that there is none."""
SEARCHES = 8
"""Poses from which a target is searched that was not found from the start of the episode."""
UNLIKELY = 1e-6
"""So seldom two draws of one distribution look as different."""
NUM_ENVS = 3


@check("task-numbers")
def numbers_are_in_their_ranges(task: Task, robot: Robot) -> None:
    """Distances and durations are positive, counts whole and positive, shares in (0, 1], rewards finite."""
    for name in ("epsilon", "control_period"):
        value = getattr(task, name)
        require(math.isfinite(value) and value > 0.0, f"{name} is {value}, not a positive number")
    for name in ("horizon", "decision_period"):
        value = getattr(task, name)
        require(isinstance(value, int) and value > 0, f"{name} is {value!r}, not a positive whole number")
    for name in ("speed", "acceleration"):
        require(0.0 < getattr(task, name) <= 1.0, f"{name} is {getattr(task, name)}, not a share in (0, 1]")
    for name in ("ground_reward", "step_reward"):
        require(math.isfinite(getattr(task, name)), f"{name} is {getattr(task, name)}")
    require(isinstance(task.ends_at_target, bool), f"ends_at_target is {task.ends_at_target!r}, neither True nor False")


@check("task-words")
def words_are_lines(task: Task, robot: Robot) -> None:
    """``harness describe`` says in one line each what starts, targets and their reward are."""
    words = (task.start_in_words(robot), task.target_in_words(robot), task.target_reward_in_words(), task.action)
    for text in words:
        require(isinstance(text, str) and text and "\n" not in text, f"{text!r} is not one line of text")


@check("task-own-robot")
def the_own_robot_passes(task: Task, robot: Robot) -> None:
    """`robot` is the name of an arm that `check` lets pass."""
    task.check(load_robot(task.robot))


@check("task-starts")
def starts_are_in_the_joint_ranges(task: Task, robot: Robot) -> None:
    """A start is (dof,), float64, finite, and no joint is beyond an end of its range."""
    rng = np.random.default_rng(0)
    for _ in range(DRAWS):
        start = task.draw_start(robot, rng)
        _require_array("a start", start, (robot.dof,))
        require((start >= robot.lower).all() and (start <= robot.upper).all(), "the start {} leaves the ranges", start)


@check("task-targets")
def targets_are_points(task: Task, robot: Robot) -> None:
    """There are as many targets as asked for: positions (count, 3), float64, finite, and flags (count,), bool."""
    for count in (1, 16):
        position, relative = task.draw_targets(robot, np.random.default_rng(0), count)
        _require_array(f"the position of {count} targets", position, (count, 3))
        same = relative.shape == (count,) and relative.dtype == bool
        require(same, f"relative of {count} targets is {relative.dtype} {relative.shape}, not bool ({count},)")


@check("task-draws")
def draws_depend_on_the_stream_alone(task: Task, robot: Robot) -> None:
    """The same random stream gives the same starts and targets, whatever else was drawn before."""
    first = _draws(task, robot)
    np.random.random(7)
    task.draw_start(robot, np.random.default_rng(1))
    task.draw_targets(robot, np.random.default_rng(1), 3)
    require(np.array_equal(first, _draws(task, robot)), "the same stream gave other starts or targets")


@check("task-varies")
def episodes_are_alike_where_it_says_so(task: Task, robot: Robot) -> None:
    """A task with `varies` False has the same start and targets for every random stream."""
    if not varies(task):
        same = np.array_equal(_draws(task, robot), _draws(task, robot, seed=1))
        require(same, "varies is False, and another stream gave other starts or targets")


@check("task-targets-in-reach")
def targets_can_be_reached(task: Task, robot: Robot) -> None:
    """Every target is above the ground, and the arm can reach at least 95 of 100 within `epsilon` in some pose."""
    places, missed = _targets(task, robot)
    low = places[places[:, 2] < 0.0]
    require(
        not len(low),
        f"{len(low)} of {TARGETS} targets are under the ground z = 0, as {_point(low)} m: nothing can get there",
    )
    told = _out_of_reach(missed, task, robot)
    require(len(missed) <= MOST_MISSED * TARGETS, f"{told}; draw others, or keep those that reach_position reaches")


@check("task-targets-count")
def targets_do_not_depend_on_the_count(task: Task, robot: Robot) -> None:
    """The spread of targets does not depend on how many are drawn at once: the harness draws some ahead."""
    for count in (TARGETS, 4 * TARGETS):
        rng, other = np.random.default_rng(0), np.random.default_rng(0)
        many, _ = task.draw_targets(robot, rng, count)
        single = np.concatenate([task.draw_targets(robot, other, 1).position for _ in range(count)])
        if np.array_equal(single, many):
            return  # one after the other from the stream
    from scipy.stats import ks_2samp

    for axis, name in enumerate("xyz"):
        alike = ks_2samp(single[:, axis], many[:, axis]).pvalue >= UNLIKELY
        spreads = " and ".join(
            f"{draws[:, axis].min():.3g} .. {draws[:, axis].max():.3g} m" for draws in (single, many)
        )
        require(alike, f"{name} of a target depends on count: one at a time and {count} at once, it is in {spreads}")


@check("task-target-rewards")
def target_rewards_are_one_per_pose(task: Task, robot: Robot) -> None:
    """The reward of targets is (count,), float64, finite, for any poses."""
    for count in (1, DRAWS):
        poses = np.random.default_rng(0).uniform(robot.lower, robot.upper, (count, robot.dof))
        _require_array(f"the reward of {count} targets", task.target_rewards(robot, poses), (count,))


@check("task-motion")
def the_motion_takes_its_actions(task: Task, robot: Robot) -> None:
    """Actions of `action_size` move joints to targets in their ranges; so do `stay` and `increments`."""
    motion, rng = task.motion(robot), np.random.default_rng(0)
    qpos = np.tile(robot.home, (NUM_ENVS, 1))
    stay, increments = motion.stay(qpos), motion.increments()
    _require_array("stay", stay, (NUM_ENVS, motion.action_size))
    _require_array("increments", increments, (len(increments), motion.action_size))
    for action in (rng.uniform(-1.0, 1.0, stay.shape), stay, *np.repeat(increments[:, None], NUM_ENVS, axis=1)):
        move = motion.advance(qpos, np.zeros_like(qpos), action)
        _require_array("qvel", move.qvel, qpos.shape)
        for waypoint in move.waypoints:
            _require_array("a waypoint", waypoint, qpos.shape)
            inside = (waypoint >= robot.lower - 1e-9).all() and (waypoint <= robot.upper + 1e-9).all()
            require(inside, "the waypoint {} leaves the joint ranges", waypoint)


@check("task-bounds")
def bounds_are_a_space(task: Task, robot: Robot) -> None:
    """The observation's bounds are float32, of one shape (size,), each lower one below its upper one."""
    observation = task.observation(robot)
    low, high = observation.low, observation.high
    fits = low.shape == high.shape == (len(low),) and low.dtype == high.dtype == np.float32
    require(fits, f"the bounds are {low.dtype} {low.shape} and {high.dtype} {high.shape}")
    require((low < high).all(), "no number is between the bounds {} and {}", low, high)


@check("task-observations")
def observations_are_in_their_bounds(task: Task, robot: Robot) -> None:
    """In random episodes, ends included, every observation is float32, has the bounds' size, and lies within them."""
    observation = task.observation(robot)
    low, high = observation.low, observation.high
    for seen in _episodes(_env(task, robot), decisions_of(task)):
        shape = (NUM_ENVS, len(low))
        require(seen.shape == shape and seen.dtype == np.float32, f"observations are {seen.dtype} {seen.shape}")
        require((seen >= low).all() and (seen <= high).all(), "an observation leaves its bounds: {}", seen)


@check("task-observing")
def observing_changes_nothing(task: Task, robot: Robot) -> None:
    """Two calls of `observe` give the same, in arrays that the caller owns, and leave the episodes as they are."""
    env = _env(task, robot)
    env.reset(seed=0)
    before, observation = env.episodes.matrix.copy(), task.observation(robot)
    first, second = observation.observe(env.episodes), observation.observe(env.episodes)
    require(np.array_equal(env.episodes.matrix, before), "observing changed the episodes")
    require(np.array_equal(first, second), "observing twice gave two observations")
    shared = np.shares_memory(first, second) or np.shares_memory(first, env.episodes.matrix)
    require(not shared, "an observation is not the caller's own: the next one changes it")


TASK_CHECKS = (
    settings_are_frozen,
    settings_survive_json,
    numbers_are_in_their_ranges,
    words_are_lines,
    the_own_robot_passes,
    starts_are_in_the_joint_ranges,
    targets_are_points,
    targets_can_be_reached,
    targets_do_not_depend_on_the_count,
    draws_depend_on_the_stream_alone,
    episodes_are_alike_where_it_says_so,
    target_rewards_are_one_per_pose,
    the_motion_takes_its_actions,
    bounds_are_a_space,
    observations_are_in_their_bounds,
    observing_changes_nothing,
    *GOAL_CHECKS,
)


def _require_array(name: str, array: Any, shape: tuple[int, ...]) -> None:
    """A float64 array of this shape whose numbers are numbers."""
    require(isinstance(array, np.ndarray), f"{name} is a {type(array).__name__}, not an array")
    right = array.shape == shape and array.dtype == np.float64
    require(right, f"{name} is {array.dtype} {array.shape}, not float64 {shape}")
    require(np.isfinite(array).all(), "{} is {}", name, array)


@check("task-all-targets-in-reach", "warning")
def all_targets_can_be_reached(task: Task, robot: Robot) -> None:
    """None of 128 targets is out of reach: on such targets even the best policy fails."""
    _, missed = _targets(task, robot)
    require(not len(missed), f"{_out_of_reach(missed, task, robot)}: no policy succeeds on those")


TASK_WARNINGS = (all_targets_can_be_reached,)


def _targets(task: Task, robot: Robot) -> tuple[Float, Float]:
    """Where some targets are, (TARGETS, 3), [m], and those of them that are out of reach."""
    rng = np.random.default_rng(0)
    position, relative = task.draw_targets(robot, rng, TARGETS)
    starts = np.array([task.draw_start(robot, rng) for _ in range(TARGETS)])
    places: Float = np.where(relative[:, None], robot.end_effector(starts) + position, position)
    return places, places[~_are_reached(task, robot, places, starts)]


def _out_of_reach(missed: Float, task: Task, robot: Robot) -> str:
    goal = goal_of(task, robot)
    if goal is not None:
        return (
            f"at {len(missed)} of {TARGETS} targets, as {_point(missed)} m, no pose of {robot.name} was found whose "
            f"{goal.error} is within epsilon = {task.epsilon:g} {goal.unit}"
        )
    return (
        f"{len(missed)} of {TARGETS} targets are out of reach, as {_point(missed)} m: the end effector of {robot.name} "
        f"gets {robot.reach:.3g} m from its first joint at most"
    )


def _are_reached(task: Task, robot: Robot, places: Float, starts: Float) -> Mask:
    """Whether joint positions are found that are within epsilon of each target, (count,)."""
    goal = goal_of(task, robot)
    if goal is not None:
        none = np.zeros(len(places))
        numbers = goal.draw(np.random.default_rng(0), places)
        return are_met(task, robot, goal, Situation(starts, robot.end_effector(starts), places, numbers, none, none))
    rng, found = np.random.default_rng(0), np.zeros(len(places), bool)
    for _ in range(1 + SEARCHES):
        left = np.flatnonzero(~found)
        if not left.size:
            break
        _, found[left] = reach_position(robot, places[left], starts[left], tolerance=task.epsilon)
        starts = rng.uniform(robot.lower, robot.upper, starts.shape)
    return found


def _point(places: Float) -> str:
    return "({:.3g}, {:.3g}, {:.3g})".format(*places[0]) if len(places) else ""


def _draws(task: Task, robot: Robot, seed: int = 0) -> Float:
    """Some starts and targets of one stream, one after the other."""
    rng = np.random.default_rng(seed)
    starts = [task.draw_start(robot, rng) for _ in range(DRAWS)]
    position, relative = task.draw_targets(robot, rng, DRAWS)
    goal = goal_of(task, robot)
    numbers = np.zeros(0) if goal is None else goal.draw(rng, position)
    return np.concatenate([np.ravel(starts), np.ravel(position), relative, np.ravel(numbers)])


def _env(task: Task, robot: Robot) -> ReachVectorEnv:
    return ReachVectorEnv(IdealSimulator(), robot, task, NegativeDistance(), NUM_ENVS)


def _episodes(env: ReachVectorEnv, decisions: int) -> list[Float32]:
    """What is seen under random actions, the last observations of ended episodes included."""
    env.action_space.seed(0)
    seen = [env.reset(seed=0)[0]]
    for _ in range(decisions):
        observations, _, _, _, infos = env.step(env.action_space.sample())
        seen += [observations, infos.get("final_obs", observations)]
    return seen
