"""The conditions of a task at work in a batch of envs: who has which arm, which obstacles, and what is seen of it."""

import json
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Ints, Mask
from harness.conditions.clearance import Clearance, draw_clutter
from harness.conditions.conditions import Conditions
from harness.conditions.obstacles import NUMBERS
from harness.conditions.varied_robot import draw_robot
from harness.env.episodes import Episodes
from harness.env.random_streams import Seed
from harness.motion.motion import Motion
from harness.record.progress import TrainingState, as_state, prefixed, under
from harness.robot import Robot
from harness.robot.kinematics import reach_position
from harness.simulator import Simulation, Simulator, State

MOST_IDLE = 16
"""The most unused simulations that are kept open. The one that was left first is closed first."""
ALONE = np.ones(1, bool)


class VariedSimulation:
    """`num_envs` simulations of one arm, of any simulator. An env gets the arm that `arms` names at its next reset.

    Simulations are opened when first met, and kept for the next env that draws the same arm.

    Attributes:
        arms: Number of the arm that each env is to have, (num_envs,).
    """

    def __init__(
        self, simulator: Simulator, robot: Callable[[int], Robot], dof: int, num_envs: int, control_period: float
    ) -> None:
        """Open nothing yet.

        Args:
            simulator: Of all arms.
            robot: The arm of a number.
            dof: Joints of each.
            num_envs: How many envs.
            control_period: See `harness.simulator.Simulator.open`.
        """
        self.arms: Ints = np.zeros(num_envs, np.int64)
        self._simulator, self._robot, self._period = simulator, robot, control_period
        self._present = np.full(num_envs, -1)
        self._open: list[Simulation | None] = [None] * num_envs
        self._idle: list[tuple[int, Simulation]] = []
        self._awake = np.ones(num_envs, bool)
        joints = (num_envs, dof)
        self._state = State(np.zeros(joints), np.zeros(joints), np.zeros((num_envs, 3)), np.zeros(num_envs, bool))

    def reset(self, qpos: Float, mask: Mask) -> State:
        self._awake |= mask
        for k in np.flatnonzero(mask).tolist():
            self._copy(k, self._take(k).reset(qpos[k : k + 1], ALONE))
        return self._state

    def drive(self, qpos: Float, duration: float) -> State:
        for k in np.flatnonzero(self._awake).tolist():
            self._copy(k, self._arm(k).drive(qpos[k : k + 1], duration))
        return self._state

    def place(self, qpos: Float) -> State:
        for k in np.flatnonzero(self._awake).tolist():
            self._copy(k, self._arm(k).place(qpos[k : k + 1]))
        return self._state

    def read(self) -> State:
        return self._state

    def rest(self, mask: Mask) -> None:
        self._awake = ~mask

    def render(self, env: int, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        return self._arm(env).render(0, target, width, height)

    def close(self) -> None:
        for simulation in (*self._open, *(idle for _, idle in self._idle)):
            if simulation is not None:
                simulation.close()
        self._open, self._idle = [None] * len(self._open), []

    def _arm(self, env: int) -> Simulation:
        return self._open[env] or self._take(env)

    def _take(self, env: int) -> Simulation:
        """Give an env the simulation of its next arm. Its last simulation waits for another env."""
        wanted, present = int(self.arms[env]), self._open[env]
        if present is None or self._present[env] != wanted:
            if present is not None:
                self._idle.append((int(self._present[env]), present))
            self._open[env] = present = self._idle_one(wanted) or self._simulator.open(
                self._robot(wanted), 1, self._period
            )
            self._present[env] = wanted
            while len(self._idle) > MOST_IDLE:
                self._idle.pop(0)[1].close()
        return present

    def _idle_one(self, wanted: int) -> Simulation | None:
        place = next((place for place, (arm, _) in enumerate(self._idle) if arm == wanted), None)
        return None if place is None else self._idle.pop(place)[1]

    def _copy(self, env: int, state: State) -> None:
        for mine, of_one in zip(self._state, state, strict=True):
            mine[env] = of_one[0]


BLOCK = 128
"""How many steps' noise is drawn at once."""
NOISE = 0
"""What the generator of a block is for, see `Senses`."""

Draw = Callable[[int, int, int], np.random.Generator]
"""Env, purpose, number: the generator of the env's present episode for that."""


class Senses:
    """Stands between the episodes and the learner: adds noise and delays.

    The noise of a step is drawn from the env's own stream by the number of the step alone: it is the same in any batch,
    under every reward, and however often one looks.
    """

    def __init__(self, conditions: Conditions, robot: Robot, episodes: Episodes, action_size: int, draw: Draw) -> None:
        """Read `episodes`, which are not changed.

        Args:
            conditions: How noisy, how late.
            robot: The arm as it is drawn, whose kinematics the learner is told.
            episodes: As they are.
            action_size: Length of an action.
            draw: See `Draw`.
        """
        self._conditions, self._robot, self._episodes, self._draw = conditions, robot, episodes, draw
        n = len(episodes.matrix)
        self.seen = episodes.another()
        self._history = np.zeros((conditions.observation_delay + 1, *episodes.matrix.shape))
        self._queue = np.zeros((conditions.action_delay, n, action_size))
        self._noisy = conditions.is_noisy
        deviations = (
            conditions.joint_noise * robot.per_radian,
            conditions.speed_noise * robot.per_radian,
            conditions.speed_noise * np.sqrt(2.0) * robot.per_radian,
            np.full(3, conditions.target_noise),
            np.full(action_size, conditions.action_noise),
        )
        self._deviation = np.concatenate(deviations)
        self._places = np.cumsum([len(deviation) for deviation in deviations])[:-1]
        self._noise = np.zeros((n, BLOCK, len(self._deviation)))
        self._blocks = np.full(n, -1)

    def begin(self, mask: Mask, resting: Float) -> None:
        """New episodes in the envs of `mask`: they were always as they are now, and `resting`, (num_envs, action_size).

        Args:
            mask: (num_envs,).
            resting: Actions that leave the arms where they are.
        """
        self._history[:, mask] = self._episodes.matrix[mask]
        self._queue[:, mask] = resting[mask]
        self._blocks[mask] = -1

    def push(self, active: Mask | None) -> None:
        """Note that a control period is over, in the envs that are `active`; None: in all."""
        history, matrix = self._history, self._episodes.matrix
        where = slice(None) if active is None else active
        if len(history) > 1:
            history[1:, where] = history[:-1, where]
        history[0, where] = matrix[where]

    def act(self, wanted: Float, active: Mask | None) -> Float:
        """The actions of this control period, if the learner wants `wanted`, (num_envs, action_size)."""
        done = wanted
        if len(self._queue):
            done, where = self._queue[-1].copy(), slice(None) if active is None else active
            self._queue[1:, where] = self._queue[:-1, where]
            self._queue[0, where] = wanted[where]
        if self._conditions.action_noise > 0.0:
            done = np.clip(done + self._noise_now()[4], -1.0, 1.0)
        return done

    def look(self) -> Episodes:
        """The episodes as they are seen now; valid until the next look."""
        seen, conditions = self.seen, self._conditions
        seen.matrix[...] = self._history[-1]
        if self._noisy:
            joints, speeds, changes, target, _ = self._noise_now()
            seen.qpos += joints
            seen.qvel += speeds
            seen.qvel_change += changes
            seen.target += target
        if conditions.joint_noise > 0.0 or conditions.length_variation > 0.0:
            # What an arm knows of its end effector follows from its joint angles and its drawing.
            seen.end_effector[...] = self._robot.end_effector(seen.qpos)
        if self._noisy or conditions.length_variation > 0.0:
            seen.measure_offset()
        return seen

    def state(self) -> TrainingState:
        """Everything that `restore` needs; noise follows from the streams."""
        return as_state({"history": self._history.copy(), "queue": self._queue.copy()})

    def restore(self, state: TrainingState) -> None:
        """Go on from `state`, which the method of this name returned."""
        self._history[...], self._queue[...] = state["history"], state["queue"]
        self._blocks[:] = -1

    def _noise_now(self) -> list[Float]:
        """The noise of joints, speeds, their changes, target and action in the present steps, (num_envs, ...) each."""
        steps = self._episodes.step.astype(int)
        blocks = steps // BLOCK
        for k in np.flatnonzero(blocks != self._blocks):
            rng = self._draw(int(k), NOISE, int(blocks[k]))
            self._noise[k] = rng.standard_normal(self._noise.shape[1:]) * self._deviation
        self._blocks[:] = blocks
        return np.split(self._noise[np.arange(len(steps)), steps % BLOCK], self._places, axis=1)


SPAWN_KEY = 21
"""The key of the env's stream for conditions. It is apart from those of `harness.env.random_streams.Streams`."""
CLUTTER = 1
"""A purpose of a generator, besides `harness.env.surroundings.NOISE`."""
BETWEEN = 4
"""How many poses of a control period are compared with obstacles. The last one is at its end."""


def extra_columns(conditions: Conditions) -> dict[str, int]:
    """The columns that a trace has beside the usual ones, and how many numbers each holds; see `record.trace`."""
    columns = {"arm": 1} if conditions.is_varied else {}
    if conditions.most_obstacles:
        columns |= {"obstacle": 1, "obstacles": NUMBERS * conditions.most_obstacles}
    return columns


class Surroundings:
    """The conditions of a task, for a `harness.env.vector_env.ReachVectorEnv`.

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
            placed: dict[
                tuple[int, bytes, bytes], Float
            ] = {}  # to find places takes 20 ms, and equal episodes have the same
            for k in np.flatnonzero(mask).tolist():
                episode = self._keys[k], episodes.qpos[k].tobytes(), episodes.target[k].tobytes()
                if episode not in placed:
                    placed[episode] = self._clutter(k).ravel()
                episodes.extra("obstacles")[k] = placed[episode]
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
