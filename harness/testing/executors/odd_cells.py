"""The cells that an executor is tried with: they do what trainings do, or go wrong, in one of the ways in `WAYS`.

This module is a plugin too. `installed` makes it one for a while, for this process and those that it starts.
"""

import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from harness.algorithm import ActionSpace
from harness.hookspecs import Register, hookimpl
from harness.policy import Policy
from harness.policy.gaussian import Gaussian
from harness.progress import Progress
from harness.record.cell import Cell
from harness.registry.choice import Choice

if TYPE_CHECKING:
    from harness.env import ReachVectorEnv

NAME = "harness-testing"
"""The name of the simulator, the task, the reward and the algorithm."""
STEPS = 3
LASTS = 0.5
"""Seconds that a cell lasts which shows that it runs."""
BEAT = 0.05
"""Seconds from one sign of life to the next."""
LONGEST = 12.0
"""Seconds after which a cell that hangs gives up: an executor that is broken leaves nothing behind for long."""
STOP = "stop"
"""File in the folder of notes that ends such a cell earlier."""


@hookimpl
def register_simulators(register: Register) -> None:
    """Announce the simulator of the kit."""
    register(NAME, "harness.env.ideal:IdealSimulator", summary="no dynamics, for the checks of executors")


@hookimpl
def register_tasks(register: Register) -> None:
    """Announce the FD100's task under a name of the kit."""
    register(NAME, "harness.reach:ReachTask", summary="the FD100's, for the checks of executors")


@hookimpl
def register_rewards(register: Register) -> None:
    """Announce the reward of the kit."""
    register(NAME, "harness.testing.trainings:NegativeDistance", summary="for the checks of executors")


@hookimpl
def register_algorithms(register: Register) -> None:
    """Announce the algorithm that goes wrong."""
    register(NAME, f"{__name__}:Odd", summary="goes wrong as it is told, for the checks of executors")


@dataclass(frozen=True)
class Odd:
    """Acts at random, then does what `then` says, one of `WAYS`; leaves notes in the folder `notes`."""

    then: str = ""
    notes: str = ""

    num_envs: ClassVar[int] = 1
    action_spaces: ClassVar[frozenset[ActionSpace]] = frozenset({"continuous"})

    def train(self, env: "ReachVectorEnv", steps: int, seed: int, progress: Progress) -> Policy:
        """See `harness.algorithm.Algorithm`."""
        rng, dof = np.random.default_rng(seed), env.robot.dof
        env.reset()
        for done in range(1, steps + 1):
            env.step(rng.uniform(-1.0, 1.0, (1, dof)))
            progress(done)
        if self.then:
            WAYS[self.then](Path(self.notes), str(seed))
        (seen,) = env.single_observation_space.shape or ()
        arrays = {"hidden.0.weight": rng.normal(size=(1, seen)), "hidden.0.bias": np.zeros(1)}
        arrays |= {"mean.weight": rng.normal(size=(dof, 1)), "mean.bias": np.zeros(dof), "log_std": np.zeros(dof)}
        weights = {name: array.astype(np.float32) for name, array in arrays.items()}
        return Gaussian(weights, "tanh", (-1.0,) * dof, (1.0,) * dof, NAME)


def odd_cell(seed: int = 0, then: str = "", notes: Path = Path()) -> Cell:
    """A cell of a moment.

    Args:
        seed: Its own.
        then: What it does after its training, one of `WAYS`; empty for nothing.
        notes: Where it leaves notes.
    """
    plain, task = Choice(NAME, (), NAME), Choice(NAME, (("horizon", 5),), f"{NAME}:horizon=5")
    algorithm = Choice(NAME, (("then", then), ("notes", str(notes))), f"{NAME}:then={then}")
    return Cell(plain, "fd100", task, algorithm, plain, seed, STEPS, evaluation_episodes=1)


@contextmanager
def installed(folder: Path) -> Iterator[None]:
    """These plugins are installed for this process and for those that it starts, within the block.

    Args:
        folder: Gets the metadata that an installer leaves.
    """
    metadata = folder / "harness_testing-1.0.dist-info"
    metadata.mkdir(parents=True)
    (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {NAME}\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text(f"[harness]\n{NAME} = {__name__}\n")
    before = os.environ.get("PYTHONPATH")
    sys.path.insert(0, str(folder))
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [str(folder), before]))
    try:
        yield
    finally:
        sys.path.remove(str(folder))
        if before is None:
            del os.environ["PYTHONPATH"]
        else:
            os.environ["PYTHONPATH"] = before


def _raise(notes: Path, name: str) -> None:
    raise RuntimeError("the arm fell off")


def _be_killed(notes: Path, name: str) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def _last(notes: Path, name: str) -> None:
    """Show for a moment that this cell runs."""
    _beat_for(LASTS, notes, name)


def _hang(notes: Path, name: str) -> None:
    """Tell no more progress, but live on."""
    _beat_for(LONGEST, notes, name)


def _beat_for(seconds: float, notes: Path, name: str) -> None:
    """Append the time to a file again and again."""
    until = time.monotonic() + seconds
    with (notes / name).open("a") as file:
        while time.monotonic() < until and not (notes / STOP).exists():
            file.write(f"{time.time()}\n")
            file.flush()
            time.sleep(BEAT)


WAYS: dict[str, Callable[[Path, str], None]] = {
    "raise": _raise,
    "be killed": _be_killed,
    "last": _last,
    "hang": _hang,
}
