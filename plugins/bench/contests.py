"""The contenders of an entry, ready to take turns."""

from contextlib import ExitStack, closing
from dataclasses import replace
from typing import Any, NamedTuple

import psutil

from harness import load_robot
from harness.algorithm import Algorithm
from harness.authoring.checking import closed_motion
from harness.authoring.commands import ReachEnv, ReachVectorEnv, Registry, World, choose
from harness.errors import UsageError
from harness.progress import Progress
from harness.robot import Robot
from harness.simulator import Simulator
from harness.task import Task

from .contest import CLOCK, Contender
from .entry import Entry, Setting
from .meter import Meter, TimedMethods

ENGINE_CALLS = ("reset", "drive", "place")
"""The methods of `harness.simulator.Simulation` that an env calls."""
ENGINE, LIBRARY = "bare engine", "bare library"
SIMULATOR, ENV = "simulator", "env"
CHEAP = "kinematic"
"""The simulator that algorithms train in: what is timed is the learning."""
PEER_BATCH = 64
"""Envs beside another's single one, which has no batch."""
MOST_ROWS = 64
"""Control periods of a turn of one env."""
PROBED = 16
"""Envs that are opened to see how much memory one takes."""
SPARE = 0.8
"""The share of the free memory that may be taken."""


class Contest(NamedTuple):
    """Who takes turns."""

    contenders: dict[str, Contender]
    reference: str
    """The contender that the others are measured against; empty where there is none."""


def open_contest(entry: Entry, setting: Setting, registry: Registry, stack: ExitStack) -> Contest:
    """Build what an entry names.

    Args:
        entry: What is timed.
        setting: What all entries have in common.
        registry: The plugins.
        stack: Closes what was opened.

    Raises:
        UsageError: A plugin, or a library, cannot do it; the message says why.
    """
    plugin = choose(registry, entry.of, entry.name).build(registry, entry.of)
    if entry.of == "algorithms":
        return _algorithm(plugin, entry, setting, registry, stack)
    goal: Task = choose(registry, "tasks", setting.task).build(registry, "tasks")
    robot = load_robot(setting.robot or goal.robot, registry)
    reward = choose(registry, "rewards", "baseline").build(registry, "rewards")
    world = World(plugin, robot, goal, reward)
    return _peer_env(world, entry, stack) if entry.peer else _simulator(world, entry.num_envs, stack)


def _simulator(world: World, num_envs: int, stack: ExitStack) -> Contest:
    simulator, robot, period = world.simulator, world.robot, world.task.control_period
    if num_envs > PROBED:
        require_memory(simulator, robot, num_envs, period)
    targets = closed_motion(robot, num_envs, periods_of(num_envs))
    bare = getattr(simulator, "bare_loop", None)
    # The bare engine first: what it cannot do is known before the env is opened.
    contenders = {ENGINE: Contender(bare(robot, targets, period), targets[..., 0].size)} if bare else {}
    env = stack.enter_context(closing(world.open(num_envs)))
    contenders |= _env_and_simulator(env, step_env(env, len(targets)))
    return Contest(contenders, ENGINE if bare else "")


def periods_of(num_envs: int) -> int:
    """Control periods of a turn: a batch takes fewer, so that a turn stays short."""
    return min(max(2, 8 * MOST_ROWS // num_envs), MOST_ROWS)


def step_env(env: ReachVectorEnv, decisions: int) -> Contender:
    """The env; the same random actions in each turn, episodes go on."""
    env.action_space.seed(0)
    actions = [env.action_space.sample() for _ in range(decisions)]
    env.reset(seed=0)

    def run() -> None:
        for action in actions:
            env.step(action)

    return Contender(run, decisions * env.num_envs * env.task.decision_period)


def _env_and_simulator(env: ReachVectorEnv, stepped: Contender) -> dict[str, Contender]:
    """The env untimed inside, and, in turns of its own, the calls into its simulator.

    A clock that tells CPU time is a call of the operating system. Two in every step would make the env 8 % slower than
    it is: docs/performance.md.
    """
    plain, meter = env.simulation, Meter(CLOCK)
    timed = TimedMethods(plain, ENGINE_CALLS, meter)
    return {
        SIMULATOR: replace(stepped, prepare=lambda: setattr(env, "simulation", timed), part=meter),
        ENV: replace(stepped, prepare=lambda: setattr(env, "simulation", plain)),
    }


def require_memory(simulator: Simulator, robot: Robot, num_envs: int, period: float) -> None:
    """Refuse a batch that does not fit into memory, before it is opened.

    Raises:
        UsageError: It does not; says how much it takes, judged by a few envs, and how much is free.
    """
    process = psutil.Process()
    before = process.memory_info().rss
    with closing(simulator.open(robot, PROBED, period)):
        each = max(process.memory_info().rss - before, 0) / PROBED
    needed, free = 2.0 * each * num_envs, SPARE * psutil.virtual_memory().available
    if needed > free:
        raise UsageError(
            f"{num_envs:,} envs, and as many of the bare engine, take about {needed / 2**30:.0f} GiB of memory; "
            f"{free / 2**30:.0f} GiB may be used"
        )


def _algorithm(algorithm: Any, entry: Entry, setting: Setting, registry: Registry, stack: ExitStack) -> Contest:
    task, steps = setting.task, setting.steps
    if "continuous" not in algorithm.action_spaces and ":" not in task:
        task = f"{task}:action=discrete"
    steps -= steps % algorithm.num_envs
    goal: Task = choose(registry, "tasks", task).build(registry, "tasks")
    world = World(
        choose(registry, "simulators", CHEAP).build(registry, "simulators"),
        load_robot(setting.robot or goal.robot, registry),
        goal,
        choose(registry, "rewards", "baseline").build(registry, "rewards"),
    )
    singles = [
        stack.enter_context(closing(ReachEnv(CHEAP, task, robot=setting.robot))) for _ in range(algorithm.num_envs)
    ]
    plain = singles[0] if algorithm.num_envs == 1 else singles
    env = stack.enter_context(closing(world.open(algorithm.num_envs)))
    own = Contender(lambda: _train(algorithm, env, steps), steps, prepare=lambda: env.reset(seed=0))
    if entry.peer:
        bare = algorithm.peer_trainings()[entry.peer](plain, steps, 0)
        return Contest({entry.peer: Contender(bare, steps), entry.name: own}, entry.peer)
    if not hasattr(algorithm, "bare_training"):
        return Contest({entry.name: own}, "")
    bare = algorithm.bare_training(plain, steps, 0)
    return Contest({LIBRARY: Contender(bare, steps), entry.name: own}, LIBRARY)


def _train(algorithm: Algorithm, env: ReachVectorEnv, steps: int) -> None:
    before = env.environment_steps
    algorithm.train(env, steps, 0, Progress())
    done = env.environment_steps - before
    if done < steps:
        raise UsageError(f"it took {done} of {steps} environment steps")


def _peer_env(world: World, entry: Entry, stack: ExitStack) -> Contest:
    peer = stack.enter_context(closing(world.simulator.peer_envs()[entry.peer]()))  # type: ignore[attr-defined]
    peer.action_space.seed(0)
    actions = [peer.action_space.sample() for _ in range(MOST_ROWS)]

    def run() -> None:
        for action in actions:
            _, _, terminated, truncated, _ = peer.step(action)
            if terminated or truncated:
                peer.reset()

    contenders = {entry.peer: Contender(run, len(actions), prepare=lambda: peer.reset(seed=0))}
    for num_envs in (1, PEER_BATCH):
        env = stack.enter_context(closing(world.open(num_envs)))
        contenders[f"{num_envs} env{'s' if num_envs > 1 else ''}"] = step_env(env, periods_of(num_envs))
    return Contest(contenders, entry.peer)
