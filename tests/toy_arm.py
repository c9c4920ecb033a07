"""What a third-party package brings, for tests: an ideal arm, an algorithm that learns nothing, and ways to go wrong.

It is never imported from here: the fixture `toys` installs it like any package, with a distribution of its own.
"""

import faulthandler
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, ClassVar, Literal

import numpy as np
import pydantic.dataclasses
from numpy.random import default_rng
from pydantic import Field

import harness
from harness.executor import Event
from harness.experiment.run_cell import run_cell
from harness.policy import SquashedGaussian, UniformChoice
from harness.simulator import State
from harness.task import ReachTask


@harness.hookimpl
def register_simulators(register):
    """An arm that follows its joint targets exactly, and one that does not move or goes wrong."""
    register("ideal", "toy_arm:Ideal", summary="moves exactly as told")
    register("stuck", "toy_arm:Stuck", summary="does not move")


@harness.hookimpl
def register_algorithms(register):
    """Two that learn nothing, of which one does what it is told to in the end, and some for other actions."""
    register("wander", "toy_arm:Wander", summary="acts at random")
    register("sweep", "toy_arm:Sweep", summary="turns its joints steadily")
    register("narrate", "toy_arm:Narrate", summary="tells all that a training can tell")
    register("buttons", "toy_arm:Buttons", summary="chooses among buttons")
    register("both", "toy_arm:Both", summary="takes whatever there is")


@harness.hookimpl
def register_tasks(register):
    """One whose actions cannot be chosen."""
    register("handless", "toy_arm:Handless", summary="its actions cannot be chosen")


@harness.hookimpl
def register_executors(register):
    """Cells in this process."""
    register("here", "toy_arm:Here", summary="in this process, one after another")


@harness.hookimpl
def register_trackers(register):
    """One that never works."""
    register("clumsy", "toy_arm:Clumsy", summary="has no server")


@dataclass(frozen=True)
class Ideal:
    """A simulator without dynamics."""

    def open(self, robot, num_envs, control_period):
        """Start."""
        return IdealSimulation(robot, num_envs)


class IdealSimulation:
    """Joints are where they are told to be."""

    def __init__(self, robot, num_envs):
        self.robot = robot
        self.qpos = np.zeros((num_envs, robot.dof))
        self.qvel = np.zeros((num_envs, robot.dof))

    def reset(self, qpos, mask):
        """Put some robots at rest."""
        self.qpos[mask], self.qvel[mask] = qpos[mask], 0.0
        return self.read()

    def drive(self, qpos, duration):
        """Arrive."""
        self.qvel = (qpos - self.qpos) / duration
        self.qpos = qpos.copy()
        return self.read()

    def read(self):
        """The state as it stands."""
        ground = np.zeros(len(self.qpos), bool)
        return State(self.qpos.copy(), self.qvel.copy(), self.robot.end_effector(self.qpos), ground)

    def close(self):
        """Nothing to release."""


@dataclass(frozen=True)
class Stuck:
    """A simulator whose arms stay where they are, until they do what `then` says."""

    then: str = ""
    note: str = ""

    def open(self, robot, num_envs, control_period):
        """Start."""
        return StuckSimulation(self, robot, num_envs)


class StuckSimulation(IdealSimulation):
    """Joints are where they were."""

    def __init__(self, simulator, robot, num_envs):
        super().__init__(robot, num_envs)
        self.simulator = simulator

    def drive(self, qpos, duration):
        """Stay."""
        if self.simulator.then == "diverge":
            self.qpos = np.full_like(self.qpos, np.nan)
        elif self.simulator.then:
            WAYS[self.simulator.then](Path(self.simulator.note))
        return self.read()


@dataclass(frozen=True)
class Wander:
    """Acts at random, then does what `then` says, then yields a policy with random weights."""

    then: str = ""
    width: float = 4  # an int where a float is declared, as people write it
    note: str = ""
    num_envs: int = 1
    action_spaces: ClassVar = frozenset({"continuous"})

    def train(self, env, steps, seed, progress):
        """Take the steps."""
        rng = default_rng(seed)
        env.reset()
        for done in range(env.num_envs, steps + 1, env.num_envs):
            env.step(rng.uniform(-1.0, 1.0, (env.num_envs, env.robot.dof)))
            progress(np.int64(done))
        if self.then:
            WAYS[self.then](Path(self.note))
        seen, dof, width = env.single_observation_space.shape[0], env.robot.dof, int(self.width)
        shapes = {"hidden.0": (width, seen), "mean": (dof, width), "log_std": (dof, width)}
        weights = {}
        for layer, (out, into) in shapes.items():
            weights[f"{layer}.weight"] = rng.normal(size=(out, into)).astype(np.float32)
            weights[f"{layer}.bias"] = np.zeros(out, np.float32)
        return SquashedGaussian(weights, "tanh", (-1.0,) * dof, (1.0,) * dof, "wander")


@pydantic.dataclasses.dataclass(frozen=True)
class Sweep:
    """Trains nothing: how far its policy moves the arm, and with it what it reaches, is in its settings."""

    effort: Annotated[float, Field(ge=0, le=1)] = 0.0
    turns: Annotated[int, Field(ge=1, le=9)] = 1
    mode: Literal["calm", "wild"] = "calm"
    layers: tuple[int, ...] = (4,)
    breaks_above: float = 1.0
    hold: str = ""
    num_envs: Annotated[int, Field(ge=1)] = 1
    action_spaces: ClassVar = frozenset({"continuous"})

    def __post_init__(self):
        """Two settings that do not go together."""
        if self.mode == "wild" and self.turns > 5:
            raise ValueError("wild with more than 5 turns")

    def train(self, env, steps, seed, progress):
        """Take the steps; stay as long as the file `hold` is there."""
        env.reset()
        for done in range(env.num_envs, steps + 1, env.num_envs):
            env.step(np.zeros((env.num_envs, env.robot.dof)))
            progress(done)
        if self.effort > self.breaks_above:
            _fail(None)
        while self.hold and Path(self.hold).exists():
            time.sleep(0.05)
        seen, dof = env.single_observation_space.shape[0], env.robot.dof
        shapes = {"hidden.0": (1, seen), "mean": (dof, 1), "log_std": (dof, 1)}
        weights = {f"{name}.weight": np.zeros(shape, np.float32) for name, shape in shapes.items()}
        weights |= {f"{name}.bias": np.zeros(shape[0], np.float32) for name, shape in shapes.items()}
        weights["mean.bias"][2] = np.arctanh(0.99 * self.effort)
        return SquashedGaussian(weights, "tanh", (-1.0,) * dof, (1.0,) * dof, "sweep")


@dataclass(frozen=True)
class Narrate:
    """Acts at random and tells all that a training can tell; what its policy does drifts with the steps."""

    num_envs: int = 1
    action_spaces: ClassVar = frozenset({"continuous"})

    def train(self, env, steps, seed, progress):
        """Take the steps."""
        rng = default_rng(seed)
        seen, dof = env.single_observation_space.shape[0], env.robot.dof
        shapes = {"hidden.0": (1, seen), "mean": (dof, 1), "log_std": (dof, 1)}

        def drifted():
            weights = {f"{name}.weight": np.zeros(shape, np.float32) for name, shape in shapes.items()}
            weights |= {f"{name}.bias": np.zeros(shape[0], np.float32) for name, shape in shapes.items()}
            weights["mean.bias"] += np.float32(done / steps)
            return SquashedGaussian(weights, "tanh", (-1.0,) * dof, (1.0,) * dof, "narrate")

        env.reset()
        for done in range(env.num_envs, steps + 1, env.num_envs):
            _, reward, *_ = env.step(rng.uniform(-1.0, 1.0, (env.num_envs, dof)))
            progress(done)
            progress.policy(np.int64(done), drifted)
            progress.scalars(done, {"Environment/Cumulative Reward": reward.sum(), **LOSSES})
        return drifted()


LOSSES = {
    "Environment/Episode Length": 5.0,
    "Losses/Policy Loss": -0.5,
    "Losses/Value Loss": 0.25,
    "Policy/Entropy": 1.5,
}


@dataclass(frozen=True)
class Buttons:
    """Takes discrete actions, presses them at random and learns nothing."""

    num_envs: int = 1
    action_spaces: ClassVar = frozenset({"discrete"})

    def train(self, env, steps, seed, progress):
        """Take the steps."""
        rng, choices = default_rng(seed), int(env.single_action_space.n)
        env.reset()
        for done in range(env.num_envs, steps + 1, env.num_envs):
            env.step(rng.integers(choices, size=env.num_envs))
            progress(done)
        return UniformChoice(choices, "buttons")


@dataclass(frozen=True)
class Both:
    """Takes whatever there is, and is never asked to learn."""

    num_envs: int = 1
    action_spaces: ClassVar = frozenset({"continuous", "discrete"})

    def train(self, env, steps, seed, progress):
        """Nothing."""
        raise NotImplementedError


@pydantic.dataclasses.dataclass(frozen=True)
class Handless(ReachTask):
    """A task whose actions are not among its parameters."""

    action: str = field(default="movej", init=False)


@dataclass(frozen=True)
class Clumsy:
    """A tracker that never works; in a bad mood it says so."""

    mood: str = "good"

    def why_not(self):
        """Whether it is in the mood."""
        return "not now" if self.mood == "bad" else ""

    def begin(self, cell):
        """Fail."""
        raise ConnectionError("no such server")


@dataclass(frozen=True)
class Here:
    """An executor without processes: quick, and no help against a crash."""

    note: str = ""

    def run(self, jobs, at_once, on_event):
        """One after another."""
        for job in jobs:
            on_event(Event("started", job.cell))
            run_cell(job.cell, job.folder, lambda steps: None, job.options)
            on_event(Event("ended", job.cell))


def _fail(note):
    raise RuntimeError("the arm\nfell off")


def _chat(note):
    print("by print")  # noqa: T201 (what a plugin does)
    sys.stderr.write("by standard error\n")
    os.write(1, b"by the file descriptor\n")
    subprocess.run([sys.executable, "-S", "-c", "print('by a child')"], check=True)


def _chat_and_die(note):
    sys.stdout.write("last words\n")
    os._exit(0)


def _wait(note):
    note.write_text(str(os.getpid()))
    while True:
        signal.pause()


def _last(note):
    note.write_text("here")
    time.sleep(0.5)


def _hang(note):
    while True:
        time.sleep(1.0)


def _hoard(note):
    kept = np.ones(600 * 2**20, np.uint8)
    time.sleep(60.0)
    return kept


WAYS = {
    "crash": lambda note: faulthandler._sigsegv(),
    "hang": _hang,
    "hoard": _hoard,
    "raise": _fail,
    "sys.exit": lambda note: sys.exit(0),
    "_exit": lambda note: os._exit(3),
    "die silently": _chat_and_die,
    "be killed": lambda note: os.kill(os.getpid(), signal.SIGKILL),
    "interrupt": lambda note: _raise_interrupt(),
    "chat": _chat,
    "ask": lambda note: input("may I? "),
    "wait": _wait,
    "last": _last,
}


def _raise_interrupt():
    raise KeyboardInterrupt
