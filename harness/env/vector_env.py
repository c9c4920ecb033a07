"""The environment: a simulator, a task and a reward as a Gymnasium vector env."""

from collections.abc import Iterator
from typing import Any, NamedTuple, TypeAlias

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from harness.arrays import Float, Float32, Mask
from harness.conditions import conditions_of
from harness.env.episodes import Episodes
from harness.env.logged_simulation import LoggedSimulation
from harness.env.random_streams import TRIES, Seed, Streams
from harness.env.surroundings import Surroundings, extra_columns
from harness.errors import UsageError
from harness.motion import Discrete, Move
from harness.progress import TrainingState, as_state, prefixed, under
from harness.record.trace import Recorder
from harness.reward import Carry, Reward, replace_where
from harness.robot import Robot
from harness.simulator import Simulation, Simulator, State
from harness.task import Task, goal_of

Infos: TypeAlias = dict[str, Any]
Actions: TypeAlias = NDArray[Any]

GROUND, REACHED, HELD, TERMINATED, TRUNCATED = range(5)
"""Columns of `Episodes.flags`."""


class Outcome(NamedTuple):
    """What a step brought, (num_envs,) each."""

    paid: Float
    terminated: Mask
    truncated: Mask
    reached: Mask
    distance: Float
    shaped: Float


class ReachVectorEnv(gymnasium.vector.VectorEnv[Float32, Actions, Float]):
    """`num_envs` robots on one reach task, paid by one reward.

    A step is a decision: `task.decision_period` environment steps under one action, fewer where the episode ends
    before. The reward of an environment step is the shaped reward plus the task's event terms; a step pays their sum.
    Each env has its own random stream: what env k meets depends on the seed and k alone, whatever the number of envs,
    the reward or the actions.

    `infos` holds, for every env, ``distance`` [m], to the target that the step was made for (of a task with a
    `harness.task.Goal` its error), ``reward_shaped`` and
    ``is_success``, whether that target was reached; in the autoreset mode SAME_STEP also ``final_obs``, (num_envs,
    observation_size), whose rows hold where ``_final_obs`` is True.

    Attributes:
        environment_steps: Taken so far, in all envs together.
        recorder: Gets one row per env and environment step, and one per episode start.
    """

    _command: Float
    _command_speed: Float
    simulation: Simulation
    _carry: Carry
    _active: Mask | None
    """Where episodes go on; None: in all envs."""

    def __init__(
        self,
        simulator: Simulator,
        robot: Robot,
        task: Task,
        reward: Reward,
        num_envs: int = 1,
        recorder: Recorder | None = None,
        autoreset_mode: AutoresetMode = AutoresetMode.SAME_STEP,
        resumable: bool = False,
    ) -> None:
        """Open the simulator.

        Args:
            simulator: Whose engine moves the arms.
            robot: The arm.
            task: What it has to do.
            reward: What it is paid for.
            num_envs: How many arms.
            recorder: Gets one row per env and environment step, and one per episode start.
            autoreset_mode: SAME_STEP starts the next episode in the step that ends one; DISABLED leaves it to
                `reset` with the option ``reset_mask``.
            resumable: Whether `state` can be asked for: what the arms are told in an episode is kept then.
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
        self.environment_steps = 0
        self._same_step = autoreset_mode is AutoresetMode.SAME_STEP
        self._define_spaces()
        self._allocate()
        self._streams = Streams(task, robot, num_envs, None)
        around, period = self._around, task.control_period
        self.simulation = simulation = around.open(simulator) if around else simulator.open(robot, num_envs, period)
        self._log: LoggedSimulation | None = None
        if resumable:
            self.simulation = self._log = LoggedSimulation(simulation, robot, num_envs)

    def reset(self, *, seed: Seed = None, options: dict[str, Any] | None = None) -> tuple[Float32, Infos]:
        """Start new episodes in all envs, or in those of the option ``reset_mask``, (num_envs,) of bool.

        Args:
            seed: Of all envs' random streams, or one per env; None goes on with the streams.
            options: See above; others are ignored, as in Gymnasium's own envs.

        Raises:
            UsageError: The mask is none of these envs.
        """
        mask = _reset_mask(options or {}, self.num_envs)
        if self._active is not None:
            self.rest(~(self._active | mask))
        if seed is not None:
            self._streams = Streams(self.task, self.robot, self.num_envs, seed)
            if self._around:
                self._around.seed(seed)
        self._start_episodes(mask)
        episodes = self.episodes
        infos = {
            "distance": episodes.distance.copy(),
            "reward_shaped": episodes.shaped.copy(),
            "is_success": episodes.flags[:, REACHED] > 0.0,
        }
        return self._observe(), infos

    def step(self, actions: Actions) -> tuple[Float32, Float, Mask, Mask, Infos]:  # type: ignore[override]
        """One decision in every env."""
        if self._starting:
            self._record_starts()
        discrete = self._discrete
        self.episodes.action[...] = actions if discrete is None else discrete.decode(actions, self._command)
        outcome = self._environment_step(self._active) if self._period == 1 else self._repeat()
        infos = {"distance": outcome.distance, "reward_shaped": outcome.shaped, "is_success": outcome.reached}
        if self._events and self._same_step:
            ended = outcome.terminated | outcome.truncated
            if ended.any():
                infos["final_obs"], infos["_final_obs"] = self._observe(), ended
                self._start_episodes(ended)
        return self._observe(), outcome.paid, outcome.terminated, outcome.truncated, infos

    def rest(self, mask: Mask) -> None:
        """Leave the envs of `mask`, (num_envs,), as they are until they are reset: nothing of them is recorded.

        What a step returns of them means nothing. The autoreset mode has to be DISABLED.
        """
        self._active = None if not mask.any() else ~mask
        if rest := getattr(self.simulation, "rest", None):
            rest(mask)

    def state(self) -> TrainingState:
        """All that `restore` needs, between two steps.

        Raises:
            UsageError: The env was opened without ``resumable=True``.
        """
        episodes, carry = self.episodes, dict(_leaves(self._carry))
        own = {
            "environment_steps": self.environment_steps,
            "streams": self._streams.pack(),
            "matrix": episodes.matrix.copy(),
            "previous_distance": episodes.sample.previous_distance.copy(),
            "command": self._command.copy(),
            "command_speed": self._command_speed.copy(),
            "inside": self._inside.copy(),
            "until_horizon": self._until_horizon,
            "starting": self._starting,
            "events": self._events,
            "started": self._started.copy(),
        }
        around = prefixed("around.", self._around.state()) if self._around else {}
        told = prefixed("simulation.", self._resumable().state())
        return {**as_state({**own, **prefixed("carry", carry)}), **around, **told}

    def restore(self, state: TrainingState) -> None:
        """Stand where an env of the same kind stood when it told its `state`, in the middle of episodes too.

        Raises:
            UsageError: The env was opened without ``resumable=True``.
            SchemaError: The simulator does not bring the arms where they stood. The env has to be reset with a seed.
        """
        episodes = self.episodes
        episodes.matrix[...] = state["matrix"]
        if self._around:
            self._around.restore(under("around.", state))
        self._resumable().restore(under("simulation.", state))
        self.environment_steps = int(state["environment_steps"])
        self._streams.unpack(state["streams"])
        episodes.sample.previous_distance[...] = state["previous_distance"]
        self._command, self._command_speed = state["command"].copy(), state["command_speed"].copy()
        self._inside, self._started = state["inside"].copy(), state["started"].copy()
        self._until_horizon = int(state["until_horizon"])
        self._starting, self._events = bool(state["starting"]), bool(state["events"])
        self._carry = _filled(self.reward.initial_carry(episodes.begin_distance.copy()), state, "carry")

    def _resumable(self) -> LoggedSimulation:
        if self._log is None:
            raise UsageError("This env does not record the commands of its arms: open it with resumable=True")
        return self._log

    def render(self) -> tuple[NDArray[np.uint8], ...]:
        """One RGB frame of every env, each (480, 640, 3)."""
        return tuple(self.simulation.render(k, self.episodes.target[k], 640, 480) for k in range(self.num_envs))

    def close_extras(self, **kwargs: Any) -> None:
        """Close the simulator; the recorder belongs to whoever made it."""
        self.simulation.close()

    def _define_spaces(self) -> None:
        spaces, batch = gymnasium.spaces, gymnasium.vector.utils.batch_space
        motion = self._motion
        self._discrete = motion if isinstance(motion, Discrete) else None
        self.single_observation_space = spaces.Box(self._observation.low, self._observation.high)
        self.single_action_space = (
            spaces.Discrete(motion.choices)
            if isinstance(motion, Discrete)
            else spaces.Box(-1.0, 1.0, (motion.action_size,), np.float32)
        )
        self.observation_space = batch(self.single_observation_space, self.num_envs)
        self.action_space = batch(self.single_action_space, self.num_envs)

    def _allocate(self) -> None:
        n, dof = self.num_envs, self.robot.dof
        # Asked for once: a task may be a dataclass with checks, and these are read in every step.
        task = self.task
        self._period, self._duration, self._jumps = task.decision_period, task.control_period, self._motion.jumps
        self._horizon = task.horizon
        # As arrays: numpy turns a float into one at every call.
        self._epsilon, self._step_reward = np.array(task.epsilon, float), np.array(task.step_reward, float)
        self._goes_on = not task.ends_at_target
        conditions = conditions_of(task)
        self.episodes = Episodes(n, dof, self._motion.action_size, extra_columns(conditions), goal_of(task, self.robot))
        self._around: Surroundings | None = None
        if not conditions.are_plain:
            robot, motion = self.robot, self._motion
            self._around = Surroundings(conditions, robot, self.episodes, motion, task.epsilon, self._duration)
        self._command = np.zeros((n, dof))
        self._command_speed = np.zeros((n, dof))
        self._inside = np.zeros(n, bool)  # where the end effector was in the target one step earlier
        self._carry = None
        self._until_horizon = 0  # no episode is truncated in so many steps
        self._starting = False
        self._active = None
        self._events = False  # whether the record holds flags of the step before
        self._started = np.zeros(n, bool)

    def _observe(self) -> Float32:
        return self._observation.observe(self._around.senses.look() if self._around else self.episodes)

    # ------------------------------------------------------------------------------------------------ steps

    def _repeat(self) -> Outcome:
        """As many environment steps as a decision lasts; an episode that ends in one is left as it ended."""
        active = np.ones(self.num_envs, bool) if self._active is None else self._active.copy()
        total = self._environment_step(active)
        for _ in range(1, self._period):
            active = active & ~(total.terminated | total.truncated)
            if not active.any():
                break
            ended, carry = self.episodes.matrix[~active], self._carry
            outcome = self._environment_step(active)
            self.episodes.matrix[~active] = ended
            self._carry = replace_where(active, self._carry, carry)
            total = Outcome(
                total.paid + np.where(active, outcome.paid, 0.0),
                total.terminated | (outcome.terminated & active),
                total.truncated | (outcome.truncated & active),
                total.reached | (outcome.reached & active),
                np.where(active, outcome.distance, total.distance),
                total.shaped + np.where(active, outcome.shaped, 0.0),
            )
        self._events |= bool((total.terminated | total.truncated).any())
        return total

    def _environment_step(self, active: Mask | None) -> Outcome:
        """One control period in every env; only `active` ones are recorded (None: all)."""
        episodes = self.episodes
        if self._events:
            self._forget_events()
        around = self._around
        action = around.senses.act(episodes.action, active) if around else episodes.action
        move = self._motion.advance(self._command, self._command_speed, action)
        self._command, self._command_speed = move.waypoints[-1], move.qvel
        state, ground = self._drive(move)
        distance = episodes.measure(state)
        self._carry, shaped = self.reward(self._carry, episodes.sample)
        episodes.shaped[...] = shaped
        paid = episodes.shaped + self._step_reward
        far = episodes.count_within(distance > self._epsilon)  # False also where the distance is no number
        reached = ~far
        if self._goes_on:
            reached, self._inside = reached & ~self._inside, reached
        struck = around.struck() if around else None
        if struck is not None:
            reached = reached & ~struck
        self._until_horizon -= 1
        terminated = truncated = np.greater_equal(ground, far)  # on the ground, or not far
        if struck is not None:
            terminated = terminated | struck
        if self._until_horizon <= 0 or np.count_nonzero(terminated) or move.held is not None:
            terminated, truncated = self._mark_events(ground, reached, struck, move)
            episodes.require_finite(distance)
            paid = paid + (episodes.events[:, 0] + episodes.events[:, 1])
        else:
            truncated = terminated.copy()  # none in either
        self._record(active)
        if around:
            around.senses.push(active)
        episodes.previous_best[...] = np.minimum(episodes.previous_best, distance)
        outcome = Outcome(paid, terminated, truncated, reached, distance, episodes.shaped.copy())
        if self._goes_on and reached.any():
            going_on = reached & ~(terminated | truncated)
            self._set_next_targets(going_on if active is None else going_on & active)
        return outcome

    def _drive(self, move: Move) -> tuple[State, Mask]:
        """Let the engine do a move; contact counts at any of its waypoints."""
        if self._jumps:
            state = self.simulation.place(move.waypoints[-1])
            return state, state.ground_contact
        if len(move.waypoints) == 1:
            state = self.simulation.drive(move.waypoints[0], self._duration)
            return state, state.ground_contact
        ground = np.zeros(self.num_envs, bool)
        for waypoint in move.waypoints:
            state = self.simulation.drive(waypoint, self._duration / len(move.waypoints))
            ground |= state.ground_contact
        return state, ground

    def _mark_events(self, ground: Mask, reached: Mask, struck: Mask | None, move: Move) -> tuple[Mask, Mask]:
        """Flags and event terms into the record; returns where episodes are terminated and truncated."""
        episodes = self.episodes
        terminated = ground | reached if not self._goes_on else ground.copy()
        if struck is not None:
            terminated |= struck
        truncated = (episodes.step >= self._horizon) & ~terminated
        held = np.zeros_like(ground) if move.held is None else move.held
        for column, flag in enumerate((ground, reached, held, terminated, truncated)):
            episodes.flags[:, column] = flag
        episodes.events[:, 0] = ground * self.task.ground_reward
        if struck is not None:
            episodes.events[:, 0] += struck * conditions_of(self.task).obstacle_reward
        if reached.any():
            episodes.events[reached, 1] = self.task.target_rewards(self.robot, episodes.qpos[reached])
        self._events = True
        return terminated, truncated

    def _forget_events(self) -> None:
        self.episodes.flags[...] = 0.0
        self.episodes.events[...] = 0.0
        self._events = False

    def _record(self, active: Mask | None) -> None:
        self.environment_steps += self.num_envs if active is None else int(active.sum())
        if self.recorder is not None:
            record = self.episodes.record
            self.recorder.append(record if active is None else record[active])

    # ------------------------------------------------------------------------------------------------ starts

    def _start_episodes(self, mask: Mask) -> None:
        """Put the arms of `mask` at new starts with new targets."""
        envs, episodes = [int(k) for k in np.flatnonzero(mask)], self.episodes
        self._command, self._command_speed = self._command.copy(), self._command_speed.copy()
        for k in envs:
            self._command[k] = self._streams.start(k)
        self._command_speed[mask] = 0.0
        if self._around:
            self._around.draw(mask)
        state = self.simulation.reset(self._command, mask)
        target, numbers = episodes.target.copy(), episodes.numbers.copy()
        for k in envs:
            target[k], numbers[k] = self._first_target(k, state)
        episodes.start(mask, state, target, numbers)
        if self._around:
            self._around.begin(mask)
        self._inside[mask] = False
        self._restart_reward(mask)
        # An episode that was left before its first step left no row: its number is free.
        episodes.episode[mask & ~self._started] += 1.0
        self._started |= mask
        self._starting = True
        self._until_horizon = self._horizon - int(episodes.step.max())

    def _first_target(self, env: int, state: State) -> tuple[Float, Float]:
        """A target, (3,), that the arm is not at, and the numbers of a goal.

        One that it can reach, where the arm is not as drawn.
        """
        for _ in range(TRIES):
            target, numbers = self._streams.target_apart(env, state.end_effector[env], state.qpos[env])
            if self._around is None or self._around.is_reached(env, target, state.qpos[env]):
                return target, numbers
        raise UsageError("length_variation is too large: a shorter arm reaches almost no target. Choose a smaller one")

    def _set_next_targets(self, mask: Mask) -> None:
        """Give the envs of `mask`, which reached their targets, the next ones."""
        episodes = self.episodes
        target, numbers = episodes.target.copy(), episodes.numbers.copy()
        for k in np.flatnonzero(mask):
            target[k], numbers[k] = self._streams.target(int(k), episodes.end_effector[k])
        episodes.set_target(mask, target, numbers)
        # Where the end effector is in the next target already, it has to leave and enter it.
        self._inside[mask] = episodes.distance[mask] <= self._epsilon
        self._restart_reward(mask)

    def _restart_reward(self, mask: Mask) -> None:
        fresh = self.reward.initial_carry(self.episodes.begin_distance.copy())
        self._carry = fresh if self._carry is None else replace_where(mask, fresh, self._carry)

    def _record_starts(self) -> None:
        """Write the start rows when the first step follows: an episode without a step leaves no trace."""
        if self.recorder is not None:
            rows = self.episodes.record[self._started]
            rows[:, self.episodes.columns("action")] = 0.0
            self.recorder.append(rows)
        self._started[:] = False
        self._starting = False
        self.episodes.step_price[:] = self._step_reward  # of every step to come


def _reset_mask(options: dict[str, Any], num_envs: int) -> Mask:
    """Which envs `reset` is for, (num_envs,)."""
    mask = np.asarray(options.get("reset_mask", np.ones(num_envs, bool)))
    if mask.shape != (num_envs,) or mask.dtype != bool:
        raise UsageError(f"The option reset_mask is {mask.dtype} of shape {mask.shape}: give bool of ({num_envs},)")
    return mask


def _leaves(carry: Carry, name: str = "") -> Iterator[tuple[str, Any]]:
    """The arrays of a reward's carry, by where they stand in it."""
    if isinstance(carry, tuple):
        for index, part in enumerate(carry):
            yield from _leaves(part, f"{name}.{index}")
    elif carry is not None:
        yield name, np.array(carry)


def _filled(fresh: Carry, state: TrainingState, name: str) -> Carry:
    """A carry of the form of `fresh` with the arrays that `_leaves` gave."""
    if isinstance(fresh, tuple):
        return tuple(_filled(part, state, f"{name}.{index}") for index, part in enumerate(fresh))
    return state[name].copy()
