"""The random streams of a batch: where episodes start and what their targets are."""

import json
import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.errors import UsageError
from harness.goal import Situation
from harness.robot import Robot
from harness.task import Task, goal_of

Seed: TypeAlias = int | list[int] | None

AHEAD = 16
"""How many targets are drawn at a time, because checking that the arm reaches them is cheap in a batch."""

TRIES = 1000
DRAWS_KEPT = 256
"""So many draws are kept for streams that stand where one stood before: those of equal seeds, and of the same reset."""


class Streams:
    """Each env has its own: what env k meets depends on the seed and k alone, whatever happens in the others."""

    def __init__(self, task: Task, robot: Robot, num_envs: int, seed: Seed) -> None:
        """Two streams per env: targets are drawn ahead, and must not depend on how many starts came between."""
        self._task, self._robot, self._goal = task, robot, goal_of(task, robot)
        self._drawn_from = lru_cache(DRAWS_KEPT)(self._draw)  # to see that an arm reaches 16 targets takes 0.5 ms
        self.seed(range(num_envs), seed)

    def seed(self, envs: Sequence[int], seed: Seed) -> None:
        """Begin all streams anew, of envs with these numbers."""
        seeds = seed if isinstance(seed, list) else [[seed, k] if seed is not None else None for k in envs]
        pairs = [np.random.SeedSequence(entropy).spawn(2) for entropy in seeds]
        self._start_rngs = [np.random.default_rng(pair[0]) for pair in pairs]
        self._target_rngs = [np.random.default_rng(pair[1]) for pair in pairs]
        self._ahead: list[list[tuple[Float, bool, Float]]] = [[] for _ in envs]

    def pack(self) -> NDArray[np.uint8]:
        """The states of the streams, as the bytes of a JSON text."""
        rngs = [[rng.bit_generator.state for rng in pair] for pair in self._pairs()]
        ahead = [[[position.tolist(), relative, *numbers] for position, relative, numbers in d] for d in self._ahead]
        return np.frombuffer(json.dumps({"rngs": rngs, "ahead": ahead}).encode(), np.uint8)

    def unpack(self, packed: NDArray[Any]) -> None:
        """Restore the states that `pack` returned for as many envs."""
        stood = json.loads(packed.tobytes())
        for pair, states in zip(self._pairs(), stood["rngs"], strict=True):
            for rng, state in zip(pair, states, strict=True):
                rng.bit_generator.state = state
        self._ahead = [
            [(np.array(position), relative, np.array(numbers)) for position, relative, *numbers in drawn]
            for drawn in stood["ahead"]
        ]

    def _pairs(self) -> list[tuple[np.random.Generator, np.random.Generator]]:
        return list(zip(self._start_rngs, self._target_rngs, strict=True))

    def start(self, env: int) -> Float:
        """Joint positions to start an episode with, (dof,)."""
        return self._task.draw_start(self._robot, self._start_rngs[env])

    def target(self, env: int, end_effector: Float) -> tuple[Float, Float]:
        """The env's next target, (3,), for an end effector at `end_effector`, and the numbers of a goal, else (0,)."""
        if not self._ahead[env]:
            self._ahead[env] = self._draw_ahead(self._target_rngs[env])[::-1]
        position, relative, numbers = self._ahead[env].pop()
        return end_effector + position if relative else position, numbers

    def target_apart(self, env: int, end_effector: Float, qpos: Float) -> tuple[Float, Float]:
        """Like `target`, but a target that the arm has not reached already.

        Args:
            env: Whose.
            end_effector: Where it is, (3,), [m].
            qpos: The joint positions, (dof,).

        Raises:
            UsageError: The arm is at all of them.
        """
        for _ in range(TRIES):
            target, numbers = self.target(env, end_effector)
            if self._error(qpos, end_effector, target, numbers) > self._task.epsilon:
                return target, numbers
        unit = "m" if self._goal is None else self._goal.unit
        raise UsageError(
            f"epsilon={self._task.epsilon} {unit} is too large: the arm reaches its targets at the start. "
            "Choose a smaller one"
        )

    def _draw_ahead(self, rng: np.random.Generator) -> list[tuple[Float, bool, Float]]:
        """The next targets of a stream, which is then behind them. They are a function of where it stands."""
        bits = rng.bit_generator
        drawn, behind = self._drawn_from(json.dumps(bits.state))
        bits.state = json.loads(behind)
        return [*drawn]

    def _draw(self, state: str) -> tuple[list[tuple[Float, bool, Float]], str]:
        rng = np.random.default_rng(0)
        rng.bit_generator.state = json.loads(state)
        position, relative = self._task.draw_targets(self._robot, rng, AHEAD)
        numbers = np.zeros((len(position), 0)) if self._goal is None else self._goal.draw(rng, position)
        drawn = [(at, bool(flag), more) for at, flag, more in zip(position, relative, numbers, strict=True)]
        return drawn, json.dumps(rng.bit_generator.state)

    def _error(self, qpos: Float, end_effector: Float, target: Float, numbers: Float) -> float:
        if self._goal is None:
            offset = target - end_effector
            return math.sqrt(offset.dot(offset))
        none = np.zeros(1)
        now = Situation(qpos[None], end_effector[None], target[None], numbers[None], none, none)
        return float(self._goal.errors(now)[0])
