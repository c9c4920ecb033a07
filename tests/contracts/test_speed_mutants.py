"""What is slow is warned of, in the words of who waits for it."""

import time
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest

import harness
from harness.env.ideal import IdealSimulation
from harness.policy import Policy, Uniform
from harness.reach import ReachTask
from harness.reward import Array, Carry, Sample
from harness.robot import Robot
from harness.simulator import State
from harness_plugins.kit import Check, IdealSimulator, kits, violations
from harness_plugins.kit.trainings import NegativeDistance

ROBOT = harness.load_robot("fd100")


class Waiting(IdealSimulation):
    """A contact solver that takes its time."""

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        time.sleep(0.008)
        return super().drive(qpos, duration)


@dataclass(frozen=True)
class SlowSimulator(IdealSimulator):
    """Opens it."""

    def open(self, robot: Robot, num_envs: int, control_period: float) -> IdealSimulation:
        return Waiting(robot, num_envs)


class SlowReward(NegativeDistance):
    """It asks a server."""

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        time.sleep(0.001)
        return super().__call__(carry, sample)


class SlowTask(ReachTask):
    """It looks for a start at length."""

    def draw_start(self, robot: Robot, rng: np.random.Generator) -> Any:
        time.sleep(0.003)
        return super().draw_start(robot, rng)


@dataclass(frozen=True)
class SlowMetric:
    """It takes its time over each row."""

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "higher"

    def __call__(self, trace: Any) -> float:
        time.sleep(6e-5 * len(trace))
        return 1.0


@dataclass(frozen=True)
class SlowAlgorithm:
    """An update of a large network."""

    num_envs: ClassVar[int] = 10
    action_spaces: ClassVar[Any] = frozenset({"continuous"})

    def train(self, env: Any, steps: int, seed: int, progress: Any) -> Policy:
        env.reset()
        for _ in range(steps // self.num_envs):
            time.sleep(0.25)
            env.step(np.zeros((self.num_envs, env.robot.dof), np.float32))
        return Uniform((-1.0,) * env.robot.dof, (1.0,) * env.robot.dof)


FOUND: dict[str, tuple[Check, tuple[Any, ...], str]] = {
    "simulator": (kits.a_simulation_is_quick, (SlowSimulator(), ROBOT), " ms: training for 100,000 steps takes "),
    "algorithm": (kits.a_training_is_quick, (SlowAlgorithm(),), "a step of training takes "),
    "reward": (kits.a_reward_is_quick, (SlowReward(),), "a step is paid in "),
    "task": (kits.an_episode_is_drawn_quickly, (SlowTask(), ROBOT), "the start and the target of an episode take "),
    "metric": (kits.a_metric_is_quick, (SlowMetric(),), "the value of a trace of"),
}


@pytest.mark.parametrize("name", FOUND)
def test_what_is_slow_is_warned_of(name: str, monkeypatch: pytest.MonkeyPatch):
    """One sentence with a time in it; no error."""
    monkeypatch.setattr(kits, "LEARNING_STEPS", 20)
    for name_of_bound in ("MOST_DRAW", "MOST_METRIC"):  # what breaks them takes several times as long
        monkeypatch.setattr(kits, name_of_bound, getattr(kits, name_of_bound) / 10.0)
    check, subject, words = FOUND[name]
    (violation,) = violations([check], *subject)
    assert violation.level == "warning"
    assert words in violation.sentence


def test_nothing_is_told_of_what_is_quick(monkeypatch: pytest.MonkeyPatch):
    """With bounds that a busy machine keeps."""
    for name in ("MOST_STEP", "MOST_REWARD", "MOST_DRAW"):
        monkeypatch.setattr(kits, name, 1.0)
    assert not list(violations([kits.a_simulation_is_quick], IdealSimulator(), ROBOT))
    assert not list(violations([kits.a_reward_is_quick], NegativeDistance()))
    assert not list(violations([kits.an_episode_is_drawn_quickly], ReachTask(), ROBOT))
