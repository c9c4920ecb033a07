"""What a task must satisfy. Each check takes the task and a robot."""

import math
from typing import Any

import numpy as np

from harness.arrays import Float, Float32
from harness.env import ReachVectorEnv
from harness.robot import Robot
from harness.robot.load import load_robot
from harness.task import Task, varies
from harness.testing.ideal import IdealSimulator
from harness.testing.trainings import NegativeDistance
from harness.testing.violations import raise_first, require, settings_are_frozen, settings_survive_json

DRAWS = 50
NUM_ENVS = 3
DECISIONS = 150


def check_task(task: Task, robot: Robot | None = None) -> None:
    """Run all `TASK_CHECKS`.

    Args:
        task: To be checked.
        robot: To do it; the task's own if None.

    Raises:
        ContractViolation: At the first check that fails.
    """
    # What is no task at all names no robot: the checks say what it is.
    raise_first(TASK_CHECKS, task, robot or load_robot(getattr(task, "robot", "fd100")))


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


def words_are_lines(task: Task, robot: Robot) -> None:
    """What ``harness describe`` says of starts, targets and their reward is one line each."""
    words = (task.start_in_words(robot), task.target_in_words(robot), task.target_reward_in_words(), task.action)
    for text in words:
        require(isinstance(text, str) and text and "\n" not in text, f"{text!r} is not one line of text")


def the_own_robot_passes(task: Task, robot: Robot) -> None:
    """`robot` is the name of an arm that `check` lets pass."""
    task.check(load_robot(task.robot))


def starts_are_in_the_joint_ranges(task: Task, robot: Robot) -> None:
    """A start is (dof,), float64, finite, and no joint is beyond an end of its range."""
    rng = np.random.default_rng(0)
    for _ in range(DRAWS):
        start = task.draw_start(robot, rng)
        _require_array("a start", start, (robot.dof,))
        require((start >= robot.lower).all() and (start <= robot.upper).all(), f"the start {start} leaves the ranges")


def targets_are_points(task: Task, robot: Robot) -> None:
    """As many targets as asked for: positions (count, 3), float64, finite, and flags (count,), bool."""
    for count in (1, 16):
        position, relative = task.draw_targets(robot, np.random.default_rng(0), count)
        _require_array(f"the position of {count} targets", position, (count, 3))
        same = relative.shape == (count,) and relative.dtype == bool
        require(same, f"relative of {count} targets is {relative.dtype} {relative.shape}, not bool ({count},)")


def draws_depend_on_the_stream_alone(task: Task, robot: Robot) -> None:
    """The same random stream gives the same starts and targets, whatever else was drawn before."""
    first = _draws(task, robot)
    np.random.random(7)
    task.draw_start(robot, np.random.default_rng(1))
    task.draw_targets(robot, np.random.default_rng(1), 3)
    require(np.array_equal(first, _draws(task, robot)), "the same stream gave other starts or targets")


def episodes_are_alike_where_it_says_so(task: Task, robot: Robot) -> None:
    """A task with `varies` False has the same start and targets whatever the random stream."""
    if not varies(task):
        same = np.array_equal(_draws(task, robot), _draws(task, robot, seed=1))
        require(same, "varies is False, and another stream gave other starts or targets")


def target_rewards_are_one_per_pose(task: Task, robot: Robot) -> None:
    """What a target pays is (count,), float64, finite, for any poses."""
    for count in (1, DRAWS):
        poses = np.random.default_rng(0).uniform(robot.lower, robot.upper, (count, robot.dof))
        _require_array(f"the reward of {count} targets", task.target_rewards(robot, poses), (count,))


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
            require(inside, f"the waypoint {waypoint} leaves the joint ranges")


def bounds_are_a_space(task: Task, robot: Robot) -> None:
    """The observation's bounds are float32, of one shape (size,), each lower one below its upper one."""
    observation = task.observation(robot)
    low, high = observation.low, observation.high
    fits = low.shape == high.shape == (len(low),) and low.dtype == high.dtype == np.float32
    require(fits, f"the bounds are {low.dtype} {low.shape} and {high.dtype} {high.shape}")
    require((low < high).all(), f"no number is between the bounds {low} and {high}")


def observations_are_in_their_bounds(task: Task, robot: Robot) -> None:
    """Over episodes at random, ends included, every observation is float32, of the bounds' size, and within them."""
    observation = task.observation(robot)
    low, high = observation.low, observation.high
    for seen in _episodes(_env(task, robot)):
        shape = (NUM_ENVS, len(low))
        require(seen.shape == shape and seen.dtype == np.float32, f"observations are {seen.dtype} {seen.shape}")
        require((seen >= low).all() and (seen <= high).all(), f"an observation leaves its bounds: {seen}")


def observing_changes_nothing(task: Task, robot: Robot) -> None:
    """`observe` gives the same twice, in arrays of the caller's own, and leaves the episodes as they are."""
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
    draws_depend_on_the_stream_alone,
    episodes_are_alike_where_it_says_so,
    target_rewards_are_one_per_pose,
    the_motion_takes_its_actions,
    bounds_are_a_space,
    observations_are_in_their_bounds,
    observing_changes_nothing,
)


def _require_array(name: str, array: Any, shape: tuple[int, ...]) -> None:
    """A float64 array of this shape whose numbers are numbers."""
    require(isinstance(array, np.ndarray), f"{name} is a {type(array).__name__}, not an array")
    right = array.shape == shape and array.dtype == np.float64
    require(right, f"{name} is {array.dtype} {array.shape}, not float64 {shape}")
    require(np.isfinite(array).all(), f"{name} is {array}")


def _draws(task: Task, robot: Robot, seed: int = 0) -> Float:
    """Some starts and targets of one stream, one after the other."""
    rng = np.random.default_rng(seed)
    starts = [task.draw_start(robot, rng) for _ in range(DRAWS)]
    position, relative = task.draw_targets(robot, rng, DRAWS)
    return np.concatenate([np.ravel(starts), np.ravel(position), relative])


def _env(task: Task, robot: Robot) -> ReachVectorEnv:
    return ReachVectorEnv(IdealSimulator(), robot, task, NegativeDistance(), NUM_ENVS)


def _episodes(env: ReachVectorEnv) -> list[Float32]:
    """What is seen under random actions, the last observations of ended episodes included."""
    env.action_space.seed(0)
    seen = [env.reset(seed=0)[0]]
    for _ in range(DECISIONS):
        observations, _, _, _, infos = env.step(env.action_space.sample())
        seen += [observations, infos.get("final_obs", observations)]
    return seen
