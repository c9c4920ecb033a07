"""The arms of the player: the baseline's task, without an engine."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from gymnasium.vector import AutoresetMode

from harness import load_robot
from harness.arrays import Float, Float32
from harness.authoring.checking import IdealSimulator
from harness.authoring.commands import choose, load_registry
from harness.env import ReachVectorEnv

Acts = Literal["joints", "branches", "choice"]
TASK, ROBOT, REWARD = "unity-reach", "unity-arm", "baseline"
STRIDE = 0.1
"""How far a discrete action moves a joint, as a share of half its range."""


@dataclass(frozen=True)
class Said:
    """What one arm says after a decision.

    Attributes:
        id: The number of its episode, which Unity calls the agent's.
        observation: All that it observes.
        reward: Since it was last heard.
        done: Whether its episode ended.
        cut: Whether the longest time did that.
    """

    id: int
    observation: Float32
    reward: float = 0.0
    done: bool = False
    cut: bool = False


class Arms:
    """Arms in the task ``unity-reach``, paid by the reward ``baseline`` and the task's events."""

    def __init__(self, count: int, horizon: int, acts: Acts, shows_positions: bool, seed: int) -> None:
        """Put them up.

        Args:
            count: How many.
            horizon: Environment steps of an episode.
            acts: How they are moved: joint angles are set, a branch for each joint moves it, or one choice does.
            shows_positions: Whether the positions of end effector and target follow on what the baseline's agent
                observes.
            seed: Starts and targets are drawn with it.
        """
        registry = load_registry()
        task = choose(registry, "tasks", f"{TASK}:horizon={horizon}").build(registry, "tasks")
        reward = choose(registry, "rewards", REWARD).build(registry, "rewards")
        robot, off = load_robot(ROBOT, registry), AutoresetMode.DISABLED
        self._env = ReachVectorEnv(IdealSimulator(), robot, task, reward, count, autoreset_mode=off)
        self._acts, self._shows_positions, self._seed = acts, shows_positions, seed
        self._ids, self._next = [0] * count, 0
        self._set = np.zeros((count, self.joints), np.float32)

    @property
    def joints(self) -> int:
        """How many joints an arm has."""
        return self._env.robot.dof

    def reset(self, seed: int | None) -> list[Said]:
        """Begin an episode of every arm; the first reset without a seed has that of the start."""
        observations, _ = self._env.reset(seed=self._seed if seed is None else seed)
        self._set[:] = 0.0
        return [Said(self._number(k), row) for k, row in enumerate(self._shown(observations))]

    def decide(self, actions: dict[int, list[float]]) -> list[Said]:
        """Move every arm, by the action for its number; of one that ends, the next episode begins at once."""
        self._set[:] = [self._joints(actions.get(it), before) for it, before in zip(self._ids, self._set, strict=True)]
        observations, paid, terminated, truncated, _ = self._env.step(self._set.copy())
        ended, shown = terminated | truncated, self._shown(observations)
        said = [
            Said(self._ids[k], shown[k], float(paid[k]), bool(ended[k]), bool(truncated[k])) for k in range(len(shown))
        ]
        if ended.any():
            observations, _ = self._env.reset(options={"reset_mask": ended})
            shown, self._set[ended] = self._shown(observations), 0.0
            said += [Said(self._number(k), shown[k]) for k in np.flatnonzero(ended).tolist()]
        return said

    def _number(self, arm: int) -> int:
        self._ids[arm], self._next = self._next, self._next + 1
        return self._ids[arm]

    def _joints(self, action: list[float] | None, before: Float32) -> Float:
        if action is None:  # it did not ask
            return before.astype(np.float64)
        if self._acts == "joints":
            return np.clip(action, -1.0, 1.0)
        moves = np.zeros(self.joints)
        if self._acts == "branches":
            moves[:] = np.asarray(action) - 1.0
        elif action[0]:
            joint, is_down = divmod(int(action[0]) - 1, 2)
            moves[joint] = -1.0 if is_down else 1.0
        return np.clip(before + STRIDE * moves, -1.0, 1.0)

    def _shown(self, observations: Float32) -> Float32:
        shown = np.hstack([observations, self._positions()]) if self._shows_positions else observations
        return shown.astype(np.float32)

    def _positions(self) -> Float:
        """End effectors and targets, (n, 6), [m]."""
        return np.hstack([self._env.episodes.end_effector, self._env.episodes.target])
