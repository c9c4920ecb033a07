"""The environment: a simulator, a task and a reward as a Gymnasium vector env."""

from typing import Any, TypeAlias

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from harness.carry import replace_where
from harness.errors import SimulationDiverged, UsageError
from harness.reward import Reward, Sample
from harness.robot import Robot
from harness.simulator import Simulator, State
from harness.task import ReachTask
from harness.trace import COLUMN, SCALARS, TraceWriter

Float = NDArray[np.float64]
Float32 = NDArray[np.float32]
Mask: TypeAlias = NDArray[np.bool_]
Infos: TypeAlias = dict[str, Any]

TARGETS_AHEAD = 16
"""Targets are drawn so many at a time: checking that the arm reaches them is cheap in a batch."""


class ReachVectorEnv(gymnasium.vector.VectorEnv[Float32, Float32, Float]):
    """`num_envs` robots on one reach task, paid by one reward.

    The reward of a step is the shaped reward plus the task's event terms. Each env has its own random stream: what
    env k meets depends on the seed and k alone, whatever the number of envs, the reward or the actions.

    `infos` holds, for every env, ``distance`` [m], ``reward_shaped`` and ``is_success``; in the autoreset mode
    SAME_STEP also ``final_obs``, (num_envs, observation_size), whose rows hold where ``_final_obs`` is True.
    """

    _command: Float
    _command_speed: Float
    _carry: Any
    _starting: bool
    _ended_before: bool

    def __init__(
        self,
        simulator: Simulator,
        robot: Robot,
        task: ReachTask,
        reward: Reward,
        num_envs: int = 1,
        recorder: TraceWriter | None = None,
        autoreset_mode: AutoresetMode = AutoresetMode.SAME_STEP,
    ) -> None:
        """Open the simulator.

        Args:
            simulator: Whose engine moves the arms.
            robot: The arm.
            task: What it has to do.
            reward: What it is paid for.
            num_envs: How many arms.
            recorder: Gets one row per env and step, and one per episode start.
            autoreset_mode: SAME_STEP starts the next episode in the step that ends one; DISABLED leaves it to
                `reset` with the option ``reset_mask``.
        """
        if autoreset_mode is AutoresetMode.NEXT_STEP:
            raise UsageError("autoreset_mode NEXT_STEP is not offered: take SAME_STEP or DISABLED")
        self.num_envs = num_envs
        self.robot, self.task, self.reward = robot, task, reward
        self.metadata = {"autoreset_mode": autoreset_mode, "render_modes": ["rgb_array"], "render_fps": 10}
        self.render_mode = "rgb_array"
        self._motion = task.motion(robot)
        self._observation = task.observation(robot)
        self.recorder = recorder
        self._same_step = autoreset_mode is AutoresetMode.SAME_STEP
        self._define_spaces()
        self._allocate()
        self._seed_streams(None)
        self.simulation = simulator.open(robot, num_envs, task.control_period)

    def reset(
        self, *, seed: int | list[int] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Float32, Infos]:
        """Start new episodes in all envs, or in those of the option ``reset_mask``, (num_envs,) of bool.

        Args:
            seed: Of all envs' random streams, or one per env; None goes on with the streams.
            options: See above.
        """
        if seed is not None:
            self._seed_streams(seed)
        mask = np.ones(self.num_envs, bool) if not options else np.asarray(options["reset_mask"], bool)
        self._start_episodes(mask)
        infos = {
            "distance": self._distance.copy(),
            "reward_shaped": self._shaped.copy(),
            "is_success": self._flags[:, 1] > 0.0,
        }
        return self._observations.astype(np.float32), infos

    def step(self, actions: Float32) -> tuple[Float32, Float, Mask, Mask, Infos]:  # type: ignore[override]
        """One control period in every env."""
        if self._starting:
            self._record_starts()
        if self._ended_before and not self._same_step:  # a finished env may be stepped on
            self._forget_events()
        self._action[...] = actions
        self._command, self._command_speed = self._motion.advance(self._command, self._command_speed, self._action)
        state = self.simulation.drive(self._command, self.task.control_period)
        distance = self._measure(state)
        paid = self._pay()
        ground, reached = state.ground_contact, ~(distance > self.task.epsilon)  # True also where it is no number
        terminated = ground | reached
        truncated = (self._step >= self.task.horizon) & ~terminated
        ended = terminated | truncated
        self._ended_before = bool(ended.any())
        if self._ended_before:
            self._require_finite(distance)
            paid += self._pay_events(ground, reached, truncated)
        if self.recorder is not None:
            self.recorder.append(self._record)
        np.minimum(self._best, distance, out=self._best)
        infos = {"distance": distance, "reward_shaped": self._shaped.copy(), "is_success": reached}
        if self._ended_before and self._same_step:
            infos["final_obs"], infos["_final_obs"] = self._observations.astype(np.float32), ended
            self._start_episodes(ended)
        return self._observations.astype(np.float32), paid, terminated, truncated, infos

    def render(self) -> tuple[NDArray[np.uint8], ...]:
        """One RGB frame of every env, each (480, 640, 3)."""
        return tuple(self.simulation.render(k, self._target[k], 640, 480) for k in range(self.num_envs))

    def close_extras(self, **kwargs: Any) -> None:
        """Close the simulator; the recorder belongs to whoever made it."""
        self.simulation.close()

    def _define_spaces(self) -> None:
        box, batch = gymnasium.spaces.Box, gymnasium.vector.utils.batch_space
        self.single_observation_space = box(self._observation.low, self._observation.high)
        self.single_action_space = box(-1.0, 1.0, (self.robot.dof,), np.float32)
        self.observation_space = batch(self.single_observation_space, self.num_envs)
        self.action_space = batch(self.single_action_space, self.num_envs)

    def _allocate(self) -> None:
        """The state of the episodes is the row to record: its columns are views into one matrix."""
        n, dof = self.num_envs, self.robot.dof
        record = np.zeros((n, len(SCALARS) + 2 * dof))
        record[:, COLUMN["env"]] = np.arange(n)
        record[:, COLUMN["episode"]] = -1
        self._record = record
        self._episode, self._step = record[:, COLUMN["episode"]], record[:, COLUMN["step"]]
        self._begin, self._best = record[:, COLUMN["begin_distance"]], record[:, COLUMN["previous_best"]]
        self._distance, self._delta = record[:, COLUMN["distance"]], record[:, COLUMN["delta_distance"]]
        first = COLUMN["reward"]
        self._shaped, self._terms = record[:, first], record[:, first + 1 : first + 4]
        self._target = record[:, COLUMN["target_x"] : COLUMN["target_x"] + 3]
        self._end_effector = record[:, COLUMN["end_effector_x"] : COLUMN["end_effector_x"] + 3]
        self._flags = record[:, COLUMN["ground"] : COLUMN["ground"] + 3]
        self._qpos = record[:, len(SCALARS) : len(SCALARS) + dof]
        self._action = record[:, len(SCALARS) + dof :]
        self._previous_distance = np.zeros(n)
        self._sample = Sample(self._begin, self._best, self._previous_distance, self._distance, self._delta, self._step)
        self._qvel: Float = np.zeros((n, dof))
        self._command = np.zeros((n, dof))
        self._command_speed = np.zeros((n, dof))
        self._observations: Float = np.zeros((n, self._observation.size))
        self._carry = None
        self._starting = False
        self._ended_before = False
        self._started = np.zeros(n, bool)

    def _seed_streams(self, seed: int | list[int] | None) -> None:
        """Two streams per env: targets are drawn ahead, and must not depend on how many starts came between."""
        seeds = (
            seed if isinstance(seed, list) else [[seed, k] if seed is not None else None for k in range(self.num_envs)]
        )
        streams = [np.random.SeedSequence(entropy).spawn(2) for entropy in seeds]
        self._start_rngs = [np.random.default_rng(pair[0]) for pair in streams]
        self._target_rngs = [np.random.default_rng(pair[1]) for pair in streams]
        self._targets_ahead: list[list[Float]] = [[] for _ in range(self.num_envs)]

    def _start_episodes(self, mask: Mask) -> None:
        """Put the arms of `mask` at new starts with new targets."""
        envs = [int(k) for k in np.flatnonzero(mask)]
        for k in envs:
            self._command[k] = self.task.draw_start(self.robot, self._start_rngs[k])
        state = self.simulation.reset(self._command, mask)
        for k in envs:
            self._target[k] = self._next_target(k, state.end_effector[k])
        self._command_speed[mask] = 0.0
        self._qvel[mask], self._qpos[mask] = state.qvel[mask], state.qpos[mask]
        self._end_effector[mask] = state.end_effector[mask]
        # An episode that was left before its first step left no row: its number is free.
        self._episode[mask & ~self._started] += 1.0
        self._started |= mask
        self._starting = True
        self._step[mask] = self._delta[mask] = self._shaped[mask] = 0.0
        self._terms[mask] = self._flags[mask] = 0.0
        self._begin_distances(mask)
        self._observe_starts(state, mask)

    def _observe_starts(self, state: State, mask: Mask) -> None:
        """Observations of the envs in `mask` alone: those of the others stand, and were seen with their last speeds."""
        fresh, target = self._observations[mask], self._target[mask]
        started = State(state.qpos[mask], state.qvel[mask], state.end_effector[mask], state.ground_contact[mask])
        self._observation.write_targets(target, fresh)
        offset = target - started.end_effector
        self._observation.write(started, started.qvel, offset, self._distance[mask], fresh)
        self._observations[mask] = fresh

    def _begin_distances(self, mask: Mask) -> None:
        distance = _length(self._target - self._end_effector)
        self._require_finite(distance)
        for column in (self._begin, self._best, self._distance, self._previous_distance):
            column[mask] = distance[mask]
        fresh = self.reward.initial_carry(self._begin.copy())
        self._carry = fresh if self._carry is None else replace_where(mask, fresh, self._carry)

    def _next_target(self, k: int, end_effector: Float) -> Float:
        """The env's next target; one that the end effector starts in is skipped."""
        for _ in range(1000):
            if not self._targets_ahead[k]:
                drawn = self.task.draw_targets(self.robot, self._target_rngs[k], TARGETS_AHEAD)
                self._targets_ahead[k] = list(drawn[::-1])
            target = self._targets_ahead[k].pop()
            if _length(target - end_effector) > self.task.epsilon:
                return target
        raise UsageError(f"epsilon={self.task.epsilon} m covers the box of targets from the start: choose less")

    def _measure(self, state: State) -> Float:
        """Bring the record up to the state after a step; previous_best is still the value before it.

        Returns:
            The distances, (num_envs,), a new array.
        """
        self._step += 1.0
        self._end_effector[...] = state.end_effector
        self._qpos[...] = state.qpos
        offset = self._target - state.end_effector
        distance = _length(offset)
        self._previous_distance[...] = self._distance
        self._distance[...] = distance
        np.subtract(distance, self._best, out=self._delta)
        self._observation.write(state, self._qvel, offset, distance, self._observations)
        self._qvel[...] = state.qvel
        return distance

    def _pay(self) -> Float:
        """Shaped reward into the record; returns its sum with the step's price, (num_envs,), a new array."""
        self._carry, shaped = self.reward(self._carry, self._sample)
        self._shaped[...] = shaped
        paid: Float = shaped + self.task.step_reward
        return paid

    def _pay_events(self, ground: Mask, reached: Mask, truncated: Mask) -> Float:
        """How the episodes end into the record; returns what that pays, (num_envs,)."""
        self._flags[:, 0], self._flags[:, 1], self._flags[:, 2] = ground, reached, truncated
        self._terms[:, 0] = ground * self.task.ground_reward
        self._terms[:, 1] = reached * self.task.target_reward
        paid: Float = self._terms[:, 0] + self._terms[:, 1]
        return paid

    def _forget_events(self) -> None:
        self._flags[...] = 0.0
        self._terms[:, :2] = 0.0

    def _record_starts(self) -> None:
        """Write the start rows when the first step follows: an episode without a step leaves no trace."""
        if self.recorder is not None:
            rows = self._record[self._started]
            rows[:, -self._action.shape[1] :] = 0.0
            self.recorder.append(rows)
        self._started[:] = False
        self._starting = False
        self._terms[:, 2] = self.task.step_reward  # of every step to come

    def _require_finite(self, distance: Float) -> None:
        if not np.isfinite(distance).all():
            envs = np.flatnonzero(~np.isfinite(distance)).tolist()
            raise SimulationDiverged(f"the end effector of env {envs} is nowhere at step {self._step[envs[0]]:.0f}")


def _length(vectors: Float) -> Float:
    """Euclidean length along the last axis."""
    length: Float = np.sqrt(np.vecdot(vectors, vectors))
    return length
