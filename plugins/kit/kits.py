"""All checks, by the kind of what they check."""

import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from harness import load_robot
from harness.algorithm import Algorithm, learns
from harness.errors import UsageError
from harness.face import warn_of
from harness.hookspecs import WORDS
from harness.log import Measure
from harness.registry import unknown_name
from harness.reward import Reward
from harness.robot import Robot
from harness.simulator import Simulator
from harness.task import Task

from .algorithms import ALGORITHM_CHECKS, ALGORITHM_WARNINGS
from .contract import Check, check, require, violations
from .environments import ENVIRONMENT_CHECKS
from .logs.checks import LOG_CHECKS
from .metrics import ALL_ENDS, METRIC_CHECKS, recorded_trace
from .reward_samples import pay, samples_for
from .rewards import REWARD_CHECKS, REWARD_WARNINGS
from .robots import ROBOT_CHECKS, ROBOT_WARNINGS, SIMULATED_ROBOT_CHECKS
from .runs import EXECUTOR_CHECKS, TRACKER_CHECKS
from .simulators.calls import a_long_simulation_neither_drifts_nor_leaks
from .simulators.checks import SIMULATOR_CHECKS, SIMULATOR_WARNINGS
from .simulators.simulations import PERIOD, opened, ramps, start_at_home
from .tasks import TASK_CHECKS, TASK_WARNINGS
from .trainings import steps_for, train_anew

TRAINING = 100_000
"""Environment steps of a training that the sentences speak of."""
MOST_STEP = 2e-3
"""Seconds of a control period of one arm: 100,000 of them in three minutes."""
MOST_LEARNING = 20e-3
"""Seconds of an environment step of a training, updates included: 100,000 of them in half an hour."""
MOST_REWARD = 200e-6
"""Seconds of what a reward pays for a step."""
MOST_DRAW = 20e-3
"""Seconds of the start and the target of an episode."""
MOST_METRIC = 0.5
"""Seconds of a trace of 1,000 rows or so; an experiment has hundreds of longer ones."""
LEARNING_STEPS = 300


@check("sim-slow", "warning")
def a_simulation_is_quick(simulator: Simulator, robot: Robot) -> None:
    """A control period of one arm takes less than 2 ms."""
    targets = ramps(robot, 1)
    with opened(simulator, robot, 1) as simulation:
        start_at_home(simulation, robot, 1)
        seconds = median_seconds([partial(simulation.drive, target, PERIOD) for target in targets])
    require(seconds <= MOST_STEP, f"a step of one arm takes {_told(seconds)}: {_training(seconds)}")


@check("algo-slow", "warning")
def a_training_is_quick(algorithm: Algorithm) -> None:
    """An environment step of a training takes less than 20 ms, in a simulator that takes almost no time."""
    if not learns(algorithm):
        return
    steps = steps_for(algorithm, LEARNING_STEPS)
    start = time.perf_counter()
    train_anew(algorithm, steps)
    seconds = (time.perf_counter() - start) / steps
    require(seconds <= MOST_LEARNING, f"a step of training takes {_told(seconds)}: {_training(seconds)}")


@check("reward-slow", "warning")
def a_reward_is_quick(reward: Reward) -> None:
    """A step is paid in less than 0.2 ms."""
    samples = samples_for(reward, 0)
    carry = reward.initial_carry(samples[0].begin_distance)
    seconds = median_seconds([partial(pay, reward, carry, sample) for sample in samples])
    require(seconds <= MOST_REWARD, f"a step is paid in {_told(seconds)}: {_training(seconds)} for the reward alone")


@check("task-slow", "warning")
def an_episode_is_drawn_quickly(task: Task, robot: Robot) -> None:
    """The start and the target of an episode are drawn in less than 20 ms."""
    rng, count = np.random.default_rng(0), 16

    def draw() -> None:
        for _ in range(count):
            task.draw_start(robot, rng)
        task.draw_targets(robot, rng, count)

    seconds = median_seconds([draw] * 3) / count
    require(seconds <= MOST_DRAW, f"the start and the target of an episode take {_told(seconds)}")


@check("metric-slow", "warning")
def a_metric_is_quick(metric: Measure) -> None:
    """The value of a trace of 1,000 rows or so takes less than half a second."""
    trace = recorded_trace(0, ALL_ENDS * 25)
    seconds = median_seconds([lambda: metric(trace)] * 3)
    require(seconds <= MOST_METRIC, f"the value of a trace of {len(trace):,} rows takes {_told(seconds)}")


def median_seconds(calls: list[Callable[[], object]]) -> float:
    """How long a call takes, the first one, which may load something, left out."""
    took = []
    for call in calls:
        start = time.perf_counter()
        call()
        took.append(time.perf_counter() - start)
    return float(np.median(took[1:]))


def _told(seconds: float) -> str:
    return f"{seconds * 1e3:.2g} ms" if seconds < 1.0 else f"{seconds:.2g} s"


def _training(seconds: float) -> str:
    minutes = seconds * TRAINING / 60.0
    took = f"{minutes:.0f} min" if minutes < 120.0 else f"{minutes / 60.0:.0f} h"
    return f"training for {TRAINING:,} steps takes {took}"


LONG_SECONDS = 900.0
"""How long ``harness check`` waits for a check that takes minutes."""


@dataclass(frozen=True)
class Kit:
    """The checks of one kind.

    Attributes:
        contract: What has to hold.
        advice: Warnings: what is slow, or was not tried.
        long: What takes minutes, and is run on demand.
        seconds: How long ``harness check`` waits for a check that is not `long`: many times what a sound plugin takes.
    """

    contract: tuple[Check, ...]
    advice: tuple[Check, ...] = ()
    long: tuple[Check, ...] = ()
    seconds: float = 60.0

    @property
    def checks(self) -> tuple[Check, ...]:
        """All of them."""
        return (*self.contract, *self.advice, *self.long)

    def seconds_of(self, check: Check) -> float:
        """How long ``harness check`` waits for one of its checks."""
        return LONG_SECONDS if check in self.long else self.seconds


KITS: Mapping[str, Kit] = MappingProxyType(
    {
        "simulators": Kit(
            SIMULATOR_CHECKS,
            (*SIMULATOR_WARNINGS, a_simulation_is_quick),
            (a_long_simulation_neither_drifts_nor_leaks,),
        ),
        "algorithms": Kit(ALGORITHM_CHECKS, (*ALGORITHM_WARNINGS, a_training_is_quick), seconds=300.0),
        "rewards": Kit(REWARD_CHECKS, (*REWARD_WARNINGS, a_reward_is_quick), seconds=15.0),
        "metrics": Kit(METRIC_CHECKS, (a_metric_is_quick,), seconds=15.0),
        "tasks": Kit(TASK_CHECKS, (*TASK_WARNINGS, an_episode_is_drawn_quickly)),
        "robots": Kit((*ROBOT_CHECKS, *SIMULATED_ROBOT_CHECKS), ROBOT_WARNINGS, seconds=120.0),
        "environments": Kit(ENVIRONMENT_CHECKS),
        "logs": Kit(LOG_CHECKS),
        "executors": Kit(EXECUTOR_CHECKS),
        "trackers": Kit(TRACKER_CHECKS),
    }
)
"""By kind, as `harness.hookspecs.KINDS` has them; the other kinds have none."""
CHECKS: Mapping[str, tuple[Check, ...]] = MappingProxyType(
    {WORDS[kind]: kit.contract for kind, kit in KITS.items()} | {"robot": ROBOT_CHECKS}
)
"""What has to hold, by the word for a kind that ``harness check --kind`` takes; of a robot, what needs no simulator."""
WITH_ROBOT = ("simulator", "task")
"""The kinds that are checked with a robot."""
WITH_FOLDER = ("log", "executor", "tracker")
"""The kinds whose checks write into an empty folder."""


def check_contract(kind: str, subject: Any, robot: Robot | None = None, *, folder: Path | None = None) -> None:
    """Run all `CHECKS` of a kind, up to the first that fails.

    Args:
        kind: Its word, such as ``reward``: a key of `CHECKS`.
        subject: The plugin. A robot may also be a registered name, or the path of a URDF or of a folder with
            ``robot.toml``. Give a tracker settings with which nothing leaves this machine.
        robot: With which a simulator or a task is checked. None: ``fd100``, and the task's own.
        folder: A log format, an executor and a tracker work in it; every machine of an executor has to see it. None:
            one for temporary files.

    Raises:
        ContractViolation: A check fails.
        UsageError: There is no such kind, it takes no such argument, or the robot cannot be read.
    """
    if kind not in CHECKS:
        raise UsageError(unknown_name("kind of contract", kind, CHECKS))
    for word, given, kinds in (("robot", robot, WITH_ROBOT), ("folder", folder, WITH_FOLDER)):
        if given is not None and kind not in kinds:
            raise UsageError(f"A {kind} is checked without a {word}: leave {word}= out")
    if kind == "robot" and not isinstance(subject, Robot):
        subject = load_robot(subject)
    # What is no task at all names no robot: the checks say what it is.
    beside = [robot or load_robot(getattr(subject, "robot", "fd100"))] if kind in WITH_ROBOT else []
    for each in CHECKS[kind]:
        with tempfile.TemporaryDirectory(dir=folder) as place:
            for violation in violations([each], subject, *beside, *[Path(place)] * (kind in WITH_FOLDER)):
                raise violation


def earlier(name: str) -> Any:
    """What 0.3 had for each kind, ``check_reward`` and ``REWARD_CHECKS``, with a warning; None of another name."""
    kind = name.lower().removeprefix("check_").removesuffix("_checks").removesuffix("_format")
    if kind not in CHECKS or name not in (f"check_{kind}", "check_log_format", f"{kind.upper()}_CHECKS"):
        return None
    use = f"CHECKS['{kind}']" if name.isupper() else f"check_contract('{kind}', ...)"
    warn_of(f"harness_plugins.kit.{name}", f"write {use}")
    word = "folder" if kind in WITH_FOLDER else "robot"

    def check_kind(subject: Any, beside: Any = None, **named: Any) -> None:
        check_contract(kind, subject, **{word: beside} | named)

    return CHECKS[kind] if name.isupper() else check_kind
