"""Every check of an environment has a broken one that fails it, and no other."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import gymnasium
import numpy as np
import pytest

from harness.environment import AnyEnv, GoalReward
from harness.reward import Given
from harness_plugins.kit import ENVIRONMENT_CHECKS, violations


class Walk(gymnasium.Env[Any, Any]):
    """A point walks on a line for ten steps."""

    def __init__(self) -> None:
        self.observation_space = gymnasium.spaces.Box(-100.0, 100.0, (1,), np.float32)
        self.action_space: gymnasium.Space[Any] = gymnasium.spaces.Box(-1.0, 1.0, (1,), np.float32)
        self.at, self.steps, self.lasts = 0.0, 0, 10

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        self.at, self.steps = float(self.start()), 0
        return self._observed(), {}

    def start(self) -> float:
        return self.np_random.uniform(-1.0, 1.0)

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        self.at += float(np.sum(action))
        self.steps += 1
        ended = self.steps >= self.lasts
        return self._observed(), -abs(self.at), False, ended, {"distance": abs(self.at)}

    def _observed(self) -> Any:
        return np.array([self.at], np.float32)


@dataclass(frozen=True)
class Sound:
    """Nothing is wrong with it."""

    lower_is_better: ClassVar[frozenset[str]] = frozenset({"distance"})

    def make(self) -> AnyEnv:
        return Walk()

    def rewards(self, env: AnyEnv) -> Mapping[str, Given]:
        return {"own": "own", "near": lambda before, action, after, info: abs(env.unwrapped.at) < 1.0}

    def behaviour(self, env: AnyEnv) -> Mapping[str, Given]:
        return {"distance": "distance"}


@dataclass
class Thawed:
    """Its parameters can be changed while it runs."""

    make, rewards, behaviour = Sound.make, Sound.rewards, Sound.behaviour


@dataclass(frozen=True)
class SetUpWithASet(Sound):
    """JSON knows no sets."""

    zones: frozenset[int] = frozenset({1})


class OutOfItsSpace(Sound):
    """It observes more than it says."""

    def make(self) -> AnyEnv:
        env = Walk()
        env.observation_space = gymnasium.spaces.Box(500.0, 600.0, (1,), np.float32)
        return env


class ActsInAMatrix(Sound):
    """No algorithm gives a matrix for an action."""

    def make(self) -> AnyEnv:
        env = Walk()
        env.action_space = gymnasium.spaces.Box(-1.0, 1.0, (2, 2), np.float32)
        return env


class NamesNoMeasure(Sound):
    """Less of what is better?"""

    lower_is_better = frozenset({"error"})


class NamesNoReward(Sound):
    """Its baseline is a reward that it has not."""

    baseline = "sparse"


class PaysNothingKnown(Sound):
    """A reward that is no number in the middle of an episode."""

    def rewards(self, env: AnyEnv) -> Mapping[str, Given]:
        return {"own": "own", "late": lambda before, action, after, info: np.inf if env.unwrapped.steps == 5 else 0.0}


class TellsNothing(Sound):
    """Its measure is a key that info never has."""

    def behaviour(self, env: AnyEnv) -> Mapping[str, Given]:
        return {"distance": "far"}


class TellsARow(Sound):
    """Its measure is a row of one number, which is recorded as none."""

    def behaviour(self, env: AnyEnv) -> Mapping[str, Given]:
        return {"distance": lambda before, action, after, info: np.abs(after)}


class NamesANumber(Sound):
    """What stands under the name of its reward cannot be asked."""

    def rewards(self, env: AnyEnv) -> Mapping[str, Given]:
        return {"own": "own", "half": 0.5}  # type: ignore[dict-item]


class LosesTheNumbersInTime(Sound):
    """Late in a long episode its measure is no number."""

    def make(self) -> AnyEnv:
        env = Walk()
        env.lasts = 150
        return env

    def behaviour(self, env: AnyEnv) -> Mapping[str, Given]:
        return {"distance": lambda before, action, after, info: np.nan if env.unwrapped.steps == 120 else 0.0}


class Farthest:
    """A measure with a memory: how far the walk has come in this episode."""

    def reset(self) -> None:
        self.farthest = 0.0

    def __call__(self, before: Any, action: Any, after: Any, info: Any) -> float:
        self.farthest = max(self.farthest, abs(float(after[0])))
        return self.farthest


class Remembers(Sound):
    """Nothing is wrong with a measure and a reward that begin with each episode."""

    farthest: ClassVar[Farthest] = Farthest()

    def rewards(self, env: AnyEnv) -> Mapping[str, Given]:
        return {"own": "own", "far": self.farthest}

    def behaviour(self, env: AnyEnv) -> Mapping[str, Given]:
        return {"distance": self.farthest}


class Unseeded(Sound):
    """One env after the other begins elsewhere, whatever the seed: a counter decides."""

    made: ClassVar[list[int]] = []

    def make(self) -> AnyEnv:
        self.made.append(1)
        env, begun = Walk(), len(self.made) / 1e3
        env.start = lambda: begun + env.np_random.uniform(-1.0, 1.0)  # type: ignore[method-assign]
        return env


class LongWalk(Walk):
    """Where no seed is given, it begins by chance."""

    def __init__(self) -> None:
        super().__init__()
        self.lasts, self.is_seeded = 500, False

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        self.is_seeded = seed is not None
        return super().reset(seed=seed, options=options)

    def start(self) -> float:
        return super().start() if self.is_seeded else np.random.default_rng().uniform(-1.0, 1.0)


class SeededForOneEpisode(Sound):
    """Its first episode depends on the seed, and no other one does; they are long."""

    def make(self) -> AnyEnv:
        return LongWalk()


class Meddles(Sound):
    """Its reward moves what it looks at."""

    def rewards(self, env: AnyEnv) -> Mapping[str, Given]:
        def pushes(before: Any, action: Any, after: Any, info: Any) -> float:
            env.unwrapped.at += 0.1
            return 0.0

        return {"own": "own", "pushes": pushes}


class NeverEnds(Sound):
    """Nobody could evaluate in it."""

    def make(self) -> AnyEnv:
        env = Walk()
        env.lasts = 10**9
        env.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (1,), np.float32)
        return env


class WalkToGoal(Walk):
    """The walk has a goal: to come to 1."""

    def __init__(self) -> None:
        super().__init__()
        box: gymnasium.Space[Any] = self.observation_space
        self.observation_space = gymnasium.spaces.Dict({"achieved_goal": box, "desired_goal": box})

    def _observed(self) -> Any:
        return {"achieved_goal": np.array([self.at], np.float32), "desired_goal": np.ones(1, np.float32)}


@dataclass(frozen=True)
class SoundWithGoals(Sound):
    """Nothing is wrong with it either."""

    def make(self) -> AnyEnv:
        return WalkToGoal()

    def rewards(self, env: AnyEnv) -> Mapping[str, Given]:
        def near(before: Any, action: Any, after: Any, info: Any) -> float:
            return -abs(float(after["achieved_goal"][0]) - 1.0)

        return {"near": near}

    def goal_rewards(self, env: AnyEnv) -> Mapping[str, GoalReward]:
        return {"near": lambda achieved, desired: -np.abs(achieved - desired)[:, 0]}


class RemembersGoals(SoundWithGoals):
    """Nothing is wrong with a reward of goals that begins with each episode."""

    def rewards(self, env: AnyEnv) -> Mapping[str, Given]:
        pay = super().rewards(env)["near"]

        class Counts:
            def reset(self) -> None:
                self.steps = 0

            def __call__(self, *step: Any) -> float:
                self.steps += 1
                return pay(*step)  # type: ignore[operator] # a function

        return {"near": Counts()}


class PaysGoalsOtherwise(SoundWithGoals):
    """By its goals it pays the square."""

    def goal_rewards(self, env: AnyEnv) -> Mapping[str, GoalReward]:
        return {"near": lambda achieved, desired: -((achieved - desired) ** 2)[:, 0]}


class PaysByWhereItStands(SoundWithGoals):
    """It looks into the env, which stands elsewhere when steps are paid again."""

    def goal_rewards(self, env: AnyEnv) -> Mapping[str, GoalReward]:
        return {"near": lambda achieved, desired: np.full(len(achieved), -abs(env.unwrapped.at - 1.0))}


class PaysOneStepAlone(SoundWithGoals):
    """It takes the goals of one step."""

    def goal_rewards(self, env: AnyEnv) -> Mapping[str, GoalReward]:
        return {"near": lambda achieved, desired: -np.linalg.norm(achieved - desired)}


class NamesNoRewardOfGoals(SoundWithGoals):
    """Its reward of goals is none of its rewards."""

    def goal_rewards(self, env: AnyEnv) -> Mapping[str, GoalReward]:
        return {"nearer": super().goal_rewards(env)["near"]}


class ShowsNoGoals(Sound):
    """Its reward of goals never meets one."""

    goal_rewards = SoundWithGoals.goal_rewards


MUTANTS: dict[type[Any], set[str]] = {
    Thawed: {"settings-frozen"},
    SetUpWithASet: {"settings-json"},
    OutOfItsSpace: {"environment-api"},
    ActsInAMatrix: {"environment-spaces"},
    NamesNoMeasure: {"environment-names"},
    NamesNoReward: {"environment-names"},
    NamesANumber: {"environment-names", "environment-finite", "environment-seeded", "environment-looks-on"},
    PaysNothingKnown: {"environment-finite"},
    TellsNothing: {"environment-finite"},
    TellsARow: {"environment-finite"},
    LosesTheNumbersInTime: {"environment-finite"},
    SeededForOneEpisode: {"environment-seeded", "environment-looks-on"},
    Unseeded: {"environment-seeded", "environment-looks-on"},
    Meddles: {"environment-looks-on"},
    PaysGoalsOtherwise: {"environment-goals"},
    PaysByWhereItStands: {"environment-goals"},
    PaysOneStepAlone: {"environment-goals"},
    NamesNoRewardOfGoals: {"environment-goals"},
    ShowsNoGoals: {"environment-goals"},
    NeverEnds: {"environment-ends"},
}


@pytest.mark.parametrize("sound", [Sound(), SoundWithGoals(), Remembers(), RemembersGoals()])
def test_the_sound_one_keeps_the_contract(sound: Any):
    """The mutants differ from it in one thing each."""
    assert [failed.check for failed in violations(ENVIRONMENT_CHECKS, sound)] == []


def test_each_mutant_fails_its_check(subtests: pytest.Subtests):
    """And no other."""
    for mutant, checks in MUTANTS.items():
        with subtests.test(mutant=mutant):
            assert {failed.check for failed in violations(ENVIRONMENT_CHECKS, mutant())} == checks
