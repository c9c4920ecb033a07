"""Plugin files, and what is planned with them."""

import pytest

from harness import load_registry
from harness.experiment.plan import check_experiment, expand
from harness.registry import read_given

HEAD = "observation, action, next_observation, info"
ENVS = """
import random
import gymnasium, numpy as np
from dataclasses import dataclass
from gymnasium.spaces import Box

class _Walk(gymnasium.Env):
    observation_space, action_space = Box(-99.0, 99.0, (1,)), Box(-1.0, 1.0, (1,))
    def __init__(self, start, length):
        self._start, self._length = start, length
    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.at, self.steps = self._start(self.np_random), 0
        return np.array([self.at], np.float32), {}
    def step(self, action):
        self.steps, self.at = self.steps + 1, self.at + float(action[0])
        ended = self.steps == self._length
        info = {"is_success": 0.0, **({"last": 1.0} if ended else {})}
        return np.array([self.at], np.float32), -abs(self.at), False, ended, info

@dataclass(frozen=True)
class Walking:
    start: str = "seeded"
    length: int = 8
    tells: str = "last"
    touches: bool = False
    def make(self):
        starts = {
            "seeded": lambda generator: generator.uniform(),
            "numpy": lambda generator: np.random.uniform(),
            "python": lambda generator: random.random(),
            "nowhere": lambda generator: float("here"),
        }
        return _Walk(starts[self.start], self.length)
    def rewards(self, env):
        def touch(*step):
            env.at += 1.0
            return 0.0
        return {"own": "own", **({"touch": touch} if self.touches else {})}
    def behaviour(self, env):
        return {self.tells: self.tells}
"""
ARM = """
from dataclasses import dataclass

@dataclass(frozen=True)
class Reward:
    k: float = 1.0
    def initial_carry(self, begin_distance):
        return ()
    def __call__(self, carry, sample):
        return carry, {paid}
"""


@pytest.fixture
def lay(tmp_path):
    """Writes files of one function each, by what it returns or does; beside them an environment, and a measure."""

    def written(*, optional=False, **bodies):
        (tmp_path / "walking.py").write_text(ENVS)
        (tmp_path / "behaviour.py").write_text(
            f"higher_is_better = ['place']\ndef place({HEAD}):\n    return float(next_observation[0])\n"
        )
        for name, body in bodies.items():
            (tmp_path / f"{name}.py").write_text(f"def {name}({HEAD}):\n    {body}\n")
        return read_given([tmp_path / "*.py"] if optional else sorted(tmp_path.glob("*.py")))

    return written


def planned(given, **keys):
    """A plan in the environment of `lay`."""
    registry = load_registry(given=given)
    asked = {"task": "walking", "algo": "random", "seeds": 2, "steps": 10, **keys}
    return expand(check_experiment(asked), registry), registry
