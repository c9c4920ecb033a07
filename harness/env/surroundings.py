"""The conditions of a task at work in a batch of envs: who has which arm, which obstacles, and what is seen of it."""

import json

import numpy as np

from harness.arrays import Float, Mask
from harness.conditions import Conditions
from harness.conditions.clearance import Clearance
from harness.conditions.clutter import draw_clutter
from harness.conditions.obstacles import NUMBERS
from harness.conditions.varied_robot import draw_robot
from harness.env.episodes import Episodes
from harness.env.random_streams import Seed
from harness.env.senses import Senses
from harness.env.varied_simulation import VariedSimulation
from harness.motion import Motion
from harness.progress import TrainingState, as_state, prefixed, under
from harness.robot import Robot
from harness.robot.inverse_kinematics import reach_position
from harness.simulator import Simulation, Simulator

SPAWN_KEY = 21
"""The key of the env's stream for conditions. It is apart from those of `harness.env.random_streams.Streams`."""
CLUTTER = 1
"""A purpose of a generator, besides `harness.env.senses.NOISE`."""
BETWEEN = 4
"""How many poses of a control period are compared with obstacles. The last one is at its end."""


def extra_columns(conditions: Conditions) -> dict[str, int]:
    """The columns that a trace has beside the usual ones, and how many numbers each holds; see `record.trace`."""
    columns = {"arm": 1} if conditions.is_varied else {}
    if conditions.most_obstacles:
        columns |= {"obstacle": 1, "obstacles": NUMBERS * conditions.most_obstacles}
    return columns


class Surroundings:
    """The conditions of a task, for a `harness.env.ReachVectorEnv`.

    Each episode has a key, drawn from the env's own stream at its start: its arm, obstacles and noise follow from it.

    Attributes:
        senses: What is seen and done.
    """

    def __init__(
        self, conditions: Conditions, robot: Robot, episodes: Episodes, motion: Motion, epsilon: float, period: float
    ) -> None:
        self._conditions, self._robot, self._episodes, self._motion = conditions, robot, episodes, motion
        self._epsilon, self._period = epsilon, period
        self._most = conditions.most_obstacles
        n = len(episodes.matrix)
        self._keys = [0] * n
        self._rngs = _streams(n, None)
        self._clearances: dict[int, Clearance] = {}
        self._varied: VariedSimulation | None = None
        self._before = np.zeros((n, robot.dof))
        self.senses = Senses(conditions, robot, episodes, motion.action_size, self._rng)

    def open(self, simulator: Simulator) -> Simulation:
        """The simulation that the arms move in."""
        n = len(self._keys)
        if not self._conditions.is_varied:
            return simulator.open(self._robot, n, self._period)
        self._varied = VariedSimulation(simulator, self._robot_of, self._robot.dof, n, self._period)
        return self._varied

    def seed(self, seed: Seed) -> None:
        """Begin all envs' streams anew."""
        self._rngs = _streams(len(self._keys), seed)

    def draw(self, mask: Mask) -> None:
        """Draw keys and arms of the next episodes in the envs of `mask`, before their arms are reset."""
        for k in np.flatnonzero(mask):
            self._keys[k] = int(self._rngs[k].integers(2**63))
            if self._varied is not None:
                self._varied.arms[k] = self._keys[k] % self._conditions.variants

    def is_reached(self, env: int, target: Float, start: Float) -> bool:
        """Whether the arm that the env has can get to a target, (3,)."""
        if self._varied is None or self._conditions.length_variation == 0.0:
            return True
        _, reached = reach_position(self._robot_of(self._arm(env)), target[None], start[None])
        return bool(reached[0])

    def begin(self, mask: Mask) -> None:
        """Place obstacles in the envs of `mask`, whose episodes have begun, and observe for the first time."""
        episodes = self._episodes
        if self._varied is not None:
            episodes.extra("arm")[mask, 0] = self._varied.arms[mask]
        if self._most:
            for k in np.flatnonzero(mask):
                episodes.extra("obstacles")[k] = self._clutter(int(k)).ravel()
            episodes.extra("obstacle")[mask] = 0.0
            self._before[mask] = episodes.qpos[mask]
        self.senses.begin(mask, self._motion.stay(episodes.qpos))

    def struck(self) -> Mask | None:
        """Whether arms touched an obstacle in the period that ended, (num_envs,); None where there is none.

        The joints went straight from where they were before, unless they jumped.
        """
        if not self._most:
            return None
        episodes, before = self._episodes, self._before
        steps = 1 if self._motion.jumps else BETWEEN
        struck = np.zeros(len(before), bool)
        share = (np.arange(steps) + 1.0)[:, None, None] / steps
        poses = before + share * (episodes.qpos - before)  # (steps, num_envs, dof)
        obstacles = episodes.extra("obstacles").reshape(len(before), -1, NUMBERS)
        arms = np.zeros(len(before), int) if self._varied is None else self._varied.arms
        for arm in sorted(set(arms.tolist())):
            mine = arms == arm
            near, flat = obstacles[mine], poses[:, mine].reshape(-1, before.shape[1])
            touched = self._clearance(arm).touches(
                flat, np.tile(near, (steps, 1, 1)), self._conditions.obstacle_clearance
            )
            struck[mine] = touched.reshape(steps, -1).any(axis=0)
        before[...] = episodes.qpos
        episodes.extra("obstacle")[:, 0] = struck
        return struck

    def state(self) -> TrainingState:
        """Everything that `restore` needs beside the episodes' matrix."""
        stood = {"rngs": [rng.bit_generator.state for rng in self._rngs], "keys": self._keys}
        streams = np.frombuffer(json.dumps(stood).encode(), np.uint8)
        own = as_state({"streams": streams, "before": self._before.copy()})
        return {**own, **prefixed("senses.", self.senses.state())}

    def restore(self, state: TrainingState) -> None:
        """Go on where `state` was told; the episodes' matrix is back already, the arms are not."""
        stood = json.loads(state["streams"].tobytes())
        for rng, was in zip(self._rngs, stood["rngs"], strict=True):
            rng.bit_generator.state = was
        self._keys, self._before[...] = list(stood["keys"]), state["before"]
        if self._varied is not None:
            self._varied.arms[:] = self._episodes.extra("arm")[:, 0].astype(int)
        self.senses.restore(under("senses.", state))

    def _rng(self, env: int, purpose: int, number: int) -> np.random.Generator:
        return np.random.default_rng([self._keys[env], purpose, number])

    def _arm(self, env: int) -> int:
        return 0 if self._varied is None else int(self._varied.arms[env])

    def _robot_of(self, arm: int) -> Robot:
        return draw_robot(self._conditions, self._robot, arm) if self._conditions.is_varied else self._robot

    def _clearance(self, arm: int) -> Clearance:
        if arm not in self._clearances:
            self._clearances[arm] = Clearance(self._robot_of(arm))
        return self._clearances[arm]

    def _clutter(self, env: int) -> Float:
        arm, episodes = self._arm(env), self._episodes
        return draw_clutter(
            self._conditions,
            self._robot_of(arm),
            self._clearance(arm),
            episodes.qpos[env].copy(),
            episodes.target[env].copy(),
            self._epsilon,
            self._rng(env, CLUTTER, 0),
        )


def _streams(num_envs: int, seed: Seed) -> list[np.random.Generator]:
    seeds = seed if isinstance(seed, list) else [[seed, k] if seed is not None else None for k in range(num_envs)]
    return [np.random.default_rng(np.random.SeedSequence(entropy, spawn_key=(SPAWN_KEY,))) for entropy in seeds]
