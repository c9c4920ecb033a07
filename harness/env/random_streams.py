"""The random streams of a batch: where episodes start and what their targets are."""

import json
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.errors import UsageError
from harness.robot import Robot
from harness.task import Task

Seed: TypeAlias = int | list[int] | None

AHEAD = 16
"""Targets are drawn so many at a time: checking that the arm reaches them is cheap in a batch."""

TRIES = 1000


class Streams:
    """Each env has its own: what env k meets depends on the seed and k alone, whatever happens in the others."""

    def __init__(self, task: Task, robot: Robot, num_envs: int, seed: Seed) -> None:
        """Two streams per env: targets are drawn ahead, and must not depend on how many starts came between."""
        self._task, self._robot = task, robot
        seeds = seed if isinstance(seed, list) else [[seed, k] if seed is not None else None for k in range(num_envs)]
        pairs = [np.random.SeedSequence(entropy).spawn(2) for entropy in seeds]
        self._start_rngs = [np.random.default_rng(pair[0]) for pair in pairs]
        self._target_rngs = [np.random.default_rng(pair[1]) for pair in pairs]
        self._ahead: list[list[tuple[Float, bool]]] = [[] for _ in range(num_envs)]

    def pack(self) -> NDArray[np.uint8]:
        """Where they stand, as the bytes of a JSON text."""
        rngs = [[rng.bit_generator.state for rng in pair] for pair in self._pairs()]
        ahead = [[[position.tolist(), relative] for position, relative in drawn] for drawn in self._ahead]
        return np.frombuffer(json.dumps({"rngs": rngs, "ahead": ahead}).encode(), np.uint8)

    def unpack(self, packed: NDArray[Any]) -> None:
        """Stand where the streams of as many envs stood when they were packed."""
        stood = json.loads(packed.tobytes())
        for pair, states in zip(self._pairs(), stood["rngs"], strict=True):
            for rng, state in zip(pair, states, strict=True):
                rng.bit_generator.state = state
        self._ahead = [[(np.array(position), relative) for position, relative in drawn] for drawn in stood["ahead"]]

    def _pairs(self) -> list[tuple[np.random.Generator, np.random.Generator]]:
        return list(zip(self._start_rngs, self._target_rngs, strict=True))

    def start(self, env: int) -> Float:
        """Joint positions to start an episode with, (dof,)."""
        return self._task.draw_start(self._robot, self._start_rngs[env])

    def target(self, env: int, end_effector: Float) -> Float:
        """The env's next target, (3,), for an end effector at `end_effector`."""
        if not self._ahead[env]:
            drawn = self._task.draw_targets(self._robot, self._target_rngs[env], AHEAD)
            self._ahead[env] = [(at, bool(relative)) for at, relative in zip(*drawn, strict=True)][::-1]
        position, relative = self._ahead[env].pop()
        return end_effector + position if relative else position

    def target_apart(self, env: int, end_effector: Float) -> Float:
        """As `target`, but one that the end effector is not in already.

        Raises:
            UsageError: All are.
        """
        for _ in range(TRIES):
            target = self.target(env, end_effector)
            if np.linalg.norm(target - end_effector) > self._task.epsilon:
                return target
        raise UsageError(f"epsilon={self._task.epsilon} m covers the targets from the start: choose less")
