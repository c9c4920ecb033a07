"""What a third-party package brings, for tests: an ideal arm, an algorithm that learns nothing, and ways to go wrong.

It is never imported from here: the fixture `toys` installs it like any package, with a distribution of its own.
"""

import os
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

import harness
from harness.executor import Event
from harness.policy import Policy
from harness.run_cell import run_cell
from harness.simulator import State


@harness.hookimpl
def register_simulators(register):
    """An arm that follows its joint targets exactly."""
    register("ideal", "toy_arm:Ideal", summary="moves exactly as told")


@harness.hookimpl
def register_algorithms(register):
    """One that does its steps at random and then does what it is told to, and one for other actions."""
    register("wander", "toy_arm:Wander", summary="acts at random")
    register("buttons", "toy_arm:Buttons", summary="chooses among buttons")


@harness.hookimpl
def register_executors(register):
    """Cells in this process."""
    register("here", "toy_arm:Here", summary="in this process, one after another")


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
class Wander:
    """Acts at random, then does what `then` says, then yields a policy with random weights."""

    then: str = ""
    width: float = 4  # an int where a float is declared, as people write it
    note: str = ""
    num_envs: int = 1
    action_spaces: ClassVar = frozenset({"continuous"})

    def train(self, env, steps, seed, progress):
        """Take the steps."""
        rng = np.random.default_rng(seed)
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
        return Policy(weights, "tanh", (-1.0,) * dof, (1.0,) * dof, "wander")


@dataclass(frozen=True)
class Buttons:
    """Takes discrete actions, which no reach task has."""

    num_envs: int = 1
    action_spaces: ClassVar = frozenset({"discrete"})


@dataclass(frozen=True)
class Here:
    """An executor without processes: quick, and no help against a crash."""

    def run(self, jobs, at_once, on_event):
        """One after another."""
        for job in jobs:
            on_event(Event("started", job.cell))
            run_cell(job.cell, job.folder, lambda steps: None)
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


WAYS = {
    "raise": _fail,
    "sys.exit": lambda note: sys.exit(0),
    "_exit": lambda note: os._exit(3),
    "die silently": _chat_and_die,
    "be killed": lambda note: os.kill(os.getpid(), signal.SIGKILL),
    "interrupt": lambda note: _raise_interrupt(),
    "chat": _chat,
    "ask": lambda note: input("may I? "),
    "wait": _wait,
}


def _raise_interrupt():
    raise KeyboardInterrupt
