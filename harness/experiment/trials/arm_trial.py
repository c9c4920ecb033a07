"""One episode of random actions of an arm whose joints are where they are told to be: all functions are asked."""

import tempfile
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path

import numpy as np

from harness.env.ideal import IdealSimulator
from harness.env.vector_env import ReachVectorEnv
from harness.errors import HarnessError, one_line, reason_of
from harness.experiment.trials.tried import Fault, Tried, error_text
from harness.log import Log
from harness.record.cell import Cell
from harness.record.folder import TRACE
from harness.record.recording.facts import FILE_BEHAVIOUR, FILE_REWARD
from harness.record.trace import TraceWriter, read_trace
from harness.registry.choice import Choice, Registry
from harness.reward import Array, Carry, Reward, Steps, pay
from harness.reward.steps import NOT_RECORDED
from harness.reward.terms import Unpaid, one_each
from harness.robot import Robot
from harness.robot.robot import load_robot
from harness.task import Task

ARMS, MOST_STEPS = 2, 500


def try_arm(
    cell: Cell, rewards: Sequence[Choice], registry: Registry, without: Collection[str], tell: Callable[[str], None]
) -> Tried:
    """Try rewards, and the measures that are given as functions, in the task of a cell.

    Args:
        cell: Whose task and robot.
        rewards: To try.
        registry: The plugins.
        without: Of these rewards and measures, named as columns are.
        tell: Told which is asked next.
    """
    robot, task = load_robot(cell.robot, registry), cell.task.build(registry, "tasks")
    faults = []
    for choice in rewards:
        if (column := f"{FILE_REWARD}{choice.label}") in without:
            continue
        tell(column)
        watched = _Watched(choice.build(registry, "rewards"))
        try:
            env = ReachVectorEnv(IdealSimulator(), robot, task, watched, ARMS)
            watched.begin()  # to learn its terms it was called on made-up steps
            _act(env)
        except (Exception, SystemExit) as error:
            if watched.reason:
                faults.append(Fault("reward", choice.label, watched.reason))
            elif not isinstance(error, HarnessError):
                return Tried(tuple(faults), (f"{cell.task.label}: the task fails: {one_line(error)}",))
    functions = registry.functions_of("measure").values()
    measures = [it.name for it in functions if it.spec and f"{FILE_BEHAVIOUR}{it.name}" not in without]
    return Tried((*faults, *_try_measures(measures, robot, task, registry, tell)))


def _try_measures(
    names: Sequence[str], robot: Robot, task: Task, registry: Registry, tell: Callable[[str], None]
) -> list[Fault]:
    """What is wrong with measures, in a trace of episodes that nothing pays."""
    faults: list[Fault] = []
    if not names:
        return faults
    tell("")
    trace = _trace_of(robot, task)
    for name in names:
        tell(f"{FILE_BEHAVIOUR}{name}")
        try:
            Choice(name).build(registry, "metrics")(trace)
        except HarnessError as error:
            faults.append(Fault("measure", name, f"fails in an episode: {reason_of(error)}."))
        except (Exception, SystemExit) as error:
            faults.append(Fault("measure", name, f"fails in an episode: {error_text(error)}."))
    tell("")
    return faults


def _trace_of(robot: Robot, task: Task) -> Log:
    with tempfile.TemporaryDirectory(prefix="harness-trial-") as folder:
        env = ReachVectorEnv(IdealSimulator(), robot, task, Unpaid(), ARMS, records=NOT_RECORDED)
        path, size = Path(folder) / TRACE, env.episodes.action.shape[1]
        with TraceWriter(path, robot.dof, size, extras=env.episodes.extras) as env.recorder:
            _act(env)
        return read_trace(path).load()


def _act(env: ReachVectorEnv) -> None:
    """Take an episode of random actions, or what there is time for."""
    env.action_space.seed(0)
    env.reset(seed=0)
    for _ in range(min(env.task.horizon, MOST_STEPS)):
        env.step(env.action_space.sample())


class _Watched:
    """A reward of which it is known whether it failed itself.

    Attributes:
        reason: What it did; empty if nothing was wrong.
    """

    def __init__(self, reward: Reward) -> None:
        self._reward, self.reason, self._step = reward, "", 0

    def begin(self) -> None:
        """Count steps from here on, and forget what went wrong before."""
        self.reason, self._step = "", 0

    def initial_carry(self, begin_distance: Array) -> Carry:
        try:
            return self._reward.initial_carry(begin_distance)
        except (Exception, SystemExit) as error:
            self.reason = f"fails in initial_carry: {error_text(error)}."
            raise

    def __call__(self, carry: Carry, steps: Steps) -> tuple[Carry, Array | Mapping[str, Array]]:
        try:
            after, paid = pay(self._reward, carry, steps)
            for value in (paid.total, *paid.terms.values()):
                if np.shape(value) != (ARMS,) or not np.isfinite(value).all():
                    raise ValueError(f"it pays {ARMS} arms {value!r}; {one_each(ARMS)}, each of them finite")
        except (Exception, SystemExit) as error:
            self.reason = f"fails in step {self._step}: {error_text(error)}."
            raise
        self._step += 1
        return after, paid.terms or paid.total
