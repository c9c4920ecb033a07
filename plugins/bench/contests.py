"""What is timed beside what, and the contenders, which take turns.

What counts is the time that this process had a core for. On a machine that does other things too, the time on the wall
says more about these than about the work; docs/performance.md has both, measured.
"""

import math
import statistics
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal, NamedTuple, TypeAlias, get_args

import psutil
from pydantic import Field

from harness.algorithm import Algorithm
from harness.authoring.checking import closed_motion
from harness.authoring.commands import ReachEnv, ReachVectorEnv, Registry, World, choose
from harness.errors import UsageError
from harness.progress import Progress
from harness.robot import Robot
from harness.simulator import Simulator
from harness.task import Task, choose_task

from .stopwatch import ENGINE as ENGINE_CALLS, Clock, Meter, TimedMethods

Kind: TypeAlias = Literal["simulators", "algorithms", "peers"]
KINDS: tuple[Kind, ...] = get_args(Kind)
Number = Annotated[float, Field(gt=0, allow_inf_nan=False)]


@dataclass(frozen=True)
class Entry:
    """One thing that is timed beside what it is built on, or beside what others have.

    Attributes:
        kind: `simulators`: a simulator and its env beside the bare engine. `algorithms`: a training beside one by the
            bare library. `peers`: either of them beside what others have.
        of: What kind of plugin: `simulators` or `algorithms`.
        name: The plugin with its parameters, ``mujoco:substeps=40``.
        num_envs: How many arms are stepped at once; of a simulator.
        peer: Its name, of an entry of the kind `peers`; else empty.
    """

    kind: Kind
    of: Literal["simulators", "algorithms"]
    name: str
    num_envs: int = 1
    peer: str = ""

    @property
    def title(self) -> str:
        """What to call it."""
        if self.peer:
            return f"{self.name} beside {self.peer}"
        if self.of == "algorithms":
            return self.name
        return f"{self.name}, {self.num_envs:,} env{'s' if self.num_envs > 1 else ''}"


@dataclass(frozen=True)
class Setting:
    """What all entries of a run have in common.

    Attributes:
        robot: Name or path; None: the task's.
        task: With its parameters.
        steps: Environment steps of one training, of `algorithms`.
        budget: About how long the turns of one round of an entry take, [s].
    """

    robot: str | None = None
    task: str = "fd100-reach"
    steps: int = 256
    budget: float = 3.0


CLOCK: Clock = time.process_time
"""[s] of all threads of this process; what it waits for does not count."""
FEWEST, MOST = 5, 25
"""Turns."""
LEAST = 0.02
"""The least time of a turn, [s]: work that takes less is repeated within the turn."""


def nothing() -> None:
    """What a contender does before a turn that needs no preparation."""


@dataclass(frozen=True)
class Contender:
    """One way to do the work.

    Attributes:
        run: Once the work; this is timed.
        steps: Environment steps of it, over all envs, >= 1.
        prepare: Called before; not timed.
        part: Of the work, what counts: a meter of what `run` calls, by the same clock. None: all of it.
    """

    run: Callable[[], object]
    steps: int
    prepare: Callable[[], object] = nothing
    part: Meter | None = None


def take_turns(contenders: Mapping[str, Contender], budget: float, clock: Clock = CLOCK) -> dict[str, list[float]]:
    """What an environment step took in each turn, [s], by contender.

    The contenders take turns, so that a slow moment of the machine meets all of them. The first time of each warms up
    and does not count; how long it takes decides how often the work is done in a turn, and how many turns there are:
    at least `FEWEST`, at most `MOST`.

    Args:
        contenders: By name.
        budget: About how long all turns may take together, [s].
        clock: Tells the time, [s].
    """
    first = {name: _seconds(it, 1, clock) * it.steps for name, it in contenders.items()}
    repeats = {name: max(1, math.ceil(LEAST / max(seconds, 1e-6))) for name, seconds in first.items()}
    turn = sum(max(seconds, 1e-6) * repeats[name] for name, seconds in first.items())
    found: dict[str, list[float]] = {name: [] for name in contenders}
    for _ in range(min(max(int(budget / turn), FEWEST), MOST)):
        for name, contender in contenders.items():
            found[name].append(_seconds(contender, repeats[name], clock))
    return found


def _seconds(contender: Contender, repeats: int, clock: Clock) -> float:
    """Per environment step, of one turn."""
    whole, part = 0.0, contender.part
    before = part.seconds if part else 0.0
    for _ in range(repeats):
        contender.prepare()
        begin = clock()
        contender.run()
        whole += clock() - begin
    return (part.seconds - before if part else whole) / (repeats * contender.steps)


@dataclass(frozen=True)
class Round:
    """What one process measured.

    Attributes:
        seconds: Of an environment step, by contender the median over the turns, [s].
        speeds: The same without the reference: how many times as fast as the reference, the median over the turns of
            what they had beside one another. Empty where there is no reference.
    """

    seconds: Mapping[str, Number]
    speeds: Mapping[str, Number]


def round_of(turns: Mapping[str, list[float]], reference: str) -> Round:
    """Medians of what `take_turns` found.

    Args:
        turns: By contender.
        reference: The contender that the others are measured against; empty for none.
    """
    others = [name for name in turns if name != reference] if reference else []
    speeds = {
        name: statistics.median(theirs / own for theirs, own in zip(turns[reference], turns[name], strict=True))
        for name in others
    }
    return Round({name: statistics.median(seconds) for name, seconds in turns.items()}, speeds)


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
    chosen, robot = choose_task(registry, setting.task, setting.robot)
    goal: Task = chosen.build(registry, "tasks")
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
    chosen, robot = choose_task(registry, task, setting.robot)
    world = World(
        choose(registry, "simulators", CHEAP).build(registry, "simulators"),
        robot,
        chosen.build(registry, "tasks"),
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
