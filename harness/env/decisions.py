"""A step of the env without Gymnasium: arms side by side, each in an episode, are moved, paid and recorded."""

from collections.abc import Collection, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.conditions.conditions import conditions_of
from harness.env.episodes import Episodes
from harness.env.ideal import LoggedSimulation
from harness.env.random_streams import TRIES, Seed, Streams
from harness.env.surroundings import Surroundings, extra_columns
from harness.errors import UsageError
from harness.motion.discrete import Discrete
from harness.motion.motion import Motion, Move
from harness.record.progress import TrainingState, as_state, prefixed, under
from harness.record.trace import QVEL, TERM, Recorder
from harness.reward import (
    Carry,
    Reward,
    Steps,
    pay,
)
from harness.reward.reward import is_finite, replace_where, require_finite
from harness.reward.terms import Needs, require_same, shown_needs
from harness.robot import Robot
from harness.simulator import Simulation, Simulator, State
from harness.task import Task, goal_of

GROUND, REACHED, HELD, TERMINATED, TRUNCATED = range(5)
"""Columns of `Episodes.flags`."""


class Events:
    """Looks at every step. It writes flags and event terms into the record if something happened.

    Attributes:
        marked: Whether the record holds flags or event terms of the step before.
    """

    def __init__(self, task: Task, robot: Robot, episodes: Episodes) -> None:
        self._task, self._robot, self._episodes = task, robot, episodes
        # Asked for once: a task may be a dataclass with checks, and these are read in every step.
        self._horizon, self._goes_on = task.horizon, not task.ends_at_target
        self._epsilon = np.array(task.epsilon, float)  # as an array: numpy turns a float into one at every call
        self._inside = np.zeros(len(episodes.matrix), bool)  # where the end effector was in the target one step earlier
        self._until_horizon = 0  # no episode is truncated in so many steps
        self.marked = False

    def begin(self, mask: Mask) -> None:
        """Episodes have begun in the envs of `mask`."""
        self._inside[mask] = False
        self._until_horizon = self._horizon - int(self._episodes.step.max())

    def set_target(self, mask: Mask) -> None:
        """Note new targets in the envs of `mask`. An end effector that is in its target must leave and enter it."""
        self._inside[mask] = self._episodes.distance[mask] <= self._epsilon

    def judge(self, distance: Float, ground: Mask, struck: Mask | None, held: Mask | None) -> Mask:
        """Where targets are reached, (num_envs,); where this step ends episodes, they are told.

        Args:
            distance: To the targets, [m], or the error of a goal.
            ground: Where arms touched the ground.
            struck: Where they touched an obstacle; None where there is none.
            held: Where they were held; None where none was.
        """
        far = self._episodes.count_within(distance > self._epsilon)  # False also where the distance is no number
        reached = ~far
        if self._goes_on:
            reached, self._inside = reached & ~self._inside, reached
        if struck is not None:
            reached = reached & ~struck
        self._until_horizon -= 1
        terminated = np.greater_equal(ground, far)  # on the ground, or not far
        if struck is not None:
            terminated = terminated | struck
        if self._until_horizon <= 0 or np.count_nonzero(terminated) or held is not None:
            self._mark(ground, reached, struck, held)
        return reached

    def forget(self) -> None:
        """Clear the record of flags and event terms."""
        self._episodes.flags[...] = 0.0
        self._episodes.events[...] = 0.0
        self._episodes.ended[...] = False
        self.marked = False

    def state(self) -> dict[str, Any]:
        """Everything that `restore` needs beside the episodes' matrix."""
        return {"inside": self._inside.copy(), "until_horizon": self._until_horizon, "events": self.marked}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on from `state`, which the method of this name returned."""
        self._inside, self._until_horizon = state["inside"].copy(), int(state["until_horizon"])
        self.marked = bool(state["events"])

    def _mark(self, ground: Mask, reached: Mask, struck: Mask | None, held: Mask | None) -> None:
        """Flags and event terms into the record, and into the step where episodes are terminated and truncated."""
        episodes = self._episodes
        terminated = ground | reached if not self._goes_on else ground.copy()
        if struck is not None:
            terminated |= struck
        truncated = (episodes.step >= self._horizon) & ~terminated
        held = np.zeros_like(ground) if held is None else held
        for column, flag in enumerate((ground, reached, held, terminated, truncated)):
            episodes.flags[:, column] = flag
        episodes.events[:, 0] = ground * self._task.ground_reward
        if struck is not None:
            episodes.events[:, 0] += struck * conditions_of(self._task).obstacle_reward
        if reached.any():
            episodes.events[reached, 1] = self._task.target_rewards(self._robot, episodes.qpos[reached])
        episodes.ended[...] = terminated, truncated
        self.marked = True


class Starts:
    """Draws starts and targets, and writes them down.

    Attributes:
        waiting: Whether episodes have begun whose first step has not followed yet.
    """

    def __init__(self, task: Task, robot: Robot, episodes: Episodes, around: Surroundings | None) -> None:
        self._task, self._robot, self._episodes, self._around = task, robot, episodes, around
        self._fresh = np.zeros(len(episodes.matrix), bool)  # where it has not
        self.waiting = False
        self._streams = Streams(task, robot, len(self._fresh), None)

    def seed(self, seed: Seed) -> None:
        """Begin the streams of all envs anew, from one seed and their numbers, or one per env; None: from chance."""
        self._streams.seed(self._episodes.env.astype(int).tolist(), seed)
        if seed is not None and self._around:
            self._around.seed(seed)

    def draw(self, mask: Mask, qpos: Float) -> Float:
        """Joint positions to start at in the envs of `mask`, those of `qpos` in the others; a new array."""
        starts = qpos.copy()
        for k in np.flatnonzero(mask).tolist():
            starts[k] = self._streams.start(k)
        if self._around:
            self._around.draw(mask)
        return starts

    def begin(self, mask: Mask, state: State) -> None:
        """Begin episodes in the envs of `mask`, whose arms were put where `state` says."""
        episodes = self._episodes
        target, numbers = episodes.target.copy(), episodes.numbers.copy()
        for k in np.flatnonzero(mask).tolist():
            target[k], numbers[k] = self._first_target(k, state)
        episodes.start(mask, state, target, numbers)
        if self._around:
            self._around.begin(mask)
        # An episode that was left before its first step left no row: its number is free.
        episodes.episode[mask & ~self._fresh] += 1.0
        self._fresh |= mask
        self.waiting = True

    def set_next(self, mask: Mask) -> None:
        """Give the envs of `mask`, which reached their targets, the next ones."""
        episodes = self._episodes
        target, numbers = episodes.target.copy(), episodes.numbers.copy()
        for k in np.flatnonzero(mask):
            target[k], numbers[k] = self._streams.target(int(k), episodes.end_effector[k])
        episodes.set_target(mask, target, numbers)

    def take_rows(self) -> Float:
        """The rows to record of the episodes that wait, which do so no more; a new array.

        It is asked for when the first step follows: an episode without a step leaves no trace.
        """
        rows = self._episodes.record[self._fresh]
        rows[:, self._episodes.columns("action")] = 0.0
        self._fresh[:] = False
        self.waiting = False
        return rows

    def state(self) -> dict[str, Any]:
        """Everything that `restore` needs beside the episodes' matrix."""
        return {"streams": self._streams.pack(), "started": self._fresh.copy(), "starting": self.waiting}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on from `state`, which the method of this name returned."""
        self._streams.unpack(state["streams"])
        self._fresh, self.waiting = state["started"].copy(), bool(state["starting"])

    def _first_target(self, env: int, state: State) -> tuple[Float, Float]:
        """A target, (3,), that the arm is not at, and the numbers of a goal.

        One that it can reach, where the arm is not as drawn.
        """
        for _ in range(TRIES):
            target, numbers = self._streams.target_apart(env, state.end_effector[env], state.qpos[env])
            if self._around is None or self._around.is_reached(env, target, state.qpos[env]):
                return target, numbers
        raise UsageError("length_variation is too large: a shorter arm reaches almost no target. Choose a smaller one")


NAME = "carry"
"""The name of the memory in a checkpoint."""


class Shaping:
    """A reward with what it remembers of each env's episode.

    Attributes:
        reward: What pays.
        carry: What it remembers; None before the first episode.
    """

    carry: Carry

    def __init__(self, reward: Reward, terms: Mapping[str, Float]) -> None:
        """Begin no episode yet.

        Args:
            reward: What pays.
            terms: By name, where what each of its terms pays is written, (num_envs, 1).
        """
        self.reward, self.carry = reward, None
        self._names = tuple(terms)
        self._columns = [(name, column[:, 0]) for name, column in terms.items()]

    def pay(self, steps: Steps) -> Float:
        """What a step pays, (num_envs,).

        Raises:
            UsageError: The reward pays other terms than at first.
        """
        self.carry, paid = pay(self.reward, self.carry, steps)
        if paid.terms or self._names:
            require_same(self._names, paid.terms)
            for name, column in self._columns:
                column[...] = paid.terms[name]
        shaped: Float = paid.total
        return shaped

    def restart(self, mask: Mask, begin_distance: Float) -> None:
        """Forget what was before in the envs of `mask`, whose targets are `begin_distance` away, (num_envs,)."""
        fresh = self.reward.initial_carry(begin_distance.copy())
        self.carry = fresh if self.carry is None else replace_where(mask, fresh, self.carry)

    def put_back(self, mask: Mask, carry: Carry) -> None:
        """Take over from `carry` the memory of the envs of `mask`."""
        self.carry = replace_where(~mask, self.carry, carry)

    def state(self) -> TrainingState:
        """Everything that `restore` needs."""
        return prefixed(NAME, dict(_leaves(self.carry)))

    def restore(self, state: Mapping[str, Any], begin_distance: Float) -> None:
        """Go on where `state` was told; the begin distances, (num_envs,), are those of then."""
        self.carry = _filled(self.reward.initial_carry(begin_distance.copy()), state, NAME)


def _leaves(carry: Carry, name: str = "") -> Iterator[tuple[str, Any]]:
    """The arrays of a reward's carry, by where they stand in it."""
    if isinstance(carry, tuple):
        for index, part in enumerate(carry):
            yield from _leaves(part, f"{name}.{index}")
    elif carry is not None:
        yield name, np.array(carry)


def _filled(fresh: Carry, state: Mapping[str, Any], name: str) -> Carry:
    """A carry of the form of `fresh` with the arrays that `_leaves` gave."""
    if isinstance(fresh, tuple):
        return tuple(_filled(part, state, f"{name}.{index}") for index, part in enumerate(fresh))
    return state[name].copy()


class Commands:
    """Joint targets. Each move of an arm begins where the move before it led.

    Attributes:
        qpos: Those commanded last, (num_envs, dof), [rad] or [m]; another array after every call.
    """

    def __init__(self, motion: Motion, num_envs: int, dof: int, duration: float) -> None:
        """Begin with all joints at rest at zero.

        Args:
            motion: Turns actions into moves.
            num_envs: How many arms.
            dof: Joints of each.
            duration: A control period, [s].
        """
        self._motion, self._jumps, self._duration = motion, motion.jumps, duration
        self.qpos, self._qvel = np.zeros((num_envs, dof)), np.zeros((num_envs, dof))

    def begin(self, mask: Mask, qpos: Float) -> None:
        """Begin anew with the arms of `mask`, which rest at `qpos`, (num_envs, dof)."""
        self.qpos, self._qvel = qpos, self._qvel.copy()
        self._qvel[mask] = 0.0

    def advance(self, action: Float) -> Move:
        """The next move. The joint targets to which it leads become the last commanded ones.

        Args:
            action: (num_envs, action_size).
        """
        move = self._motion.advance(self.qpos, self._qvel, action)
        self.qpos, self._qvel = move.waypoints[-1], move.qvel
        return move

    def drive(self, simulation: Simulation, move: Move) -> tuple[State, Mask]:
        """Let the engine do a move; contact with the ground, (num_envs,), counts at any of its waypoints."""
        if self._jumps:
            state = simulation.place(move.waypoints[-1])
            return state, state.ground_contact
        if len(move.waypoints) == 1:
            state = simulation.drive(move.waypoints[0], self._duration)
            return state, state.ground_contact
        ground = np.zeros(len(self.qpos), bool)
        for waypoint in move.waypoints:
            state = simulation.drive(waypoint, self._duration / len(move.waypoints))
            ground |= state.ground_contact
        return state, ground

    def state(self) -> dict[str, Any]:
        """Everything that `restore` needs."""
        return {"command": self.qpos.copy(), "command_speed": self._qvel.copy()}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on from `state`, which the method of this name returned."""
        self.qpos, self._qvel = state["command"].copy(), state["command_speed"].copy()


class Outcome(NamedTuple):
    """What a step brought, (num_envs,) each."""

    paid: Float
    terminated: Mask
    truncated: Mask
    reached: Mask
    distance: Float
    shaped: Float


class Decisions:
    """The decisions of a batch of arms, and the episodes that they are taken in.

    Attributes:
        episodes: Where the episodes stand.
        around: The task's conditions at work; None where it has none.
        events: Where episodes end.
        shaping: What pays.
        simulation: Moves the arms.
        recorder: Gets the rows; None where nobody asks for them.
        environment_steps: Taken so far, in all envs together.
    """

    simulation: Simulation

    def __init__(
        self, simulator: Simulator, robot: Robot, task: Task, motion: Motion, reward: Reward, num_envs: int,
        recorder: Recorder | None, resumable: bool, records: Collection[str] = (),
    ) -> None:  # fmt: skip
        """Open the simulator; see `harness.env.vector_env.ReachVectorEnv`."""
        self._num_envs, conditions = num_envs, conditions_of(task)
        # Asked for once: a task may be a dataclass with checks, and these are read in every step.
        self._decision_period, self._goes_on = task.decision_period, not task.ends_at_target
        self._step_reward = np.array(task.step_reward, float)  # as an array: numpy turns a float into one at every call
        terms = (shown_needs(reward, robot.dof, motion.action_size) or Needs()).terms
        asked = {QVEL: robot.dof} if QVEL in records else {}
        extras = {**extra_columns(conditions), **asked, **{f"{TERM}{name}": 1 for name in terms}}
        goal = goal_of(task, robot)
        self.episodes = episodes = Episodes(num_envs, robot.dof, motion.action_size, extras, goal)
        self.around: Surroundings | None = None
        if not conditions.are_plain:
            self.around = Surroundings(conditions, robot, episodes, motion, task.epsilon, task.control_period)
        self._discrete = motion if isinstance(motion, Discrete) else None
        self._commands = Commands(motion, num_envs, robot.dof, task.control_period)
        self._starts = Starts(task, robot, episodes, self.around)
        self.events, self.shaping = (
            Events(task, robot, episodes),
            Shaping(reward, {name: episodes.extra(f"{TERM}{name}") for name in terms}),
        )
        self.recorder, self.environment_steps = recorder, 0
        self._active: Mask | None = None  # where episodes go on; None: in all envs
        opened = self.around.open(simulator) if self.around else simulator.open(robot, num_envs, task.control_period)
        self._log = LoggedSimulation(opened, robot, num_envs) if resumable else None
        self.simulation = self._log or opened

    def seed(self, seed: Seed) -> None:
        """Begin the random streams of all envs anew."""
        self._starts.seed(seed)

    def start(self, mask: Mask) -> None:
        """Put the arms of `mask` at new starts with new targets."""
        self._commands.begin(mask, self._starts.draw(mask, self._commands.qpos))
        self._starts.begin(mask, self.simulation.reset(self._commands.qpos, mask))
        self._require_measured()
        self.episodes.keep_starts(mask)
        self.events.begin(mask)
        self.shaping.restart(mask, self.episodes.begin_distance)

    def rest(self, mask: Mask) -> None:
        """Leave the envs of `mask`, (num_envs,), as they are until they are woken: nothing of them is recorded."""
        self._active = None if not mask.any() else ~mask
        if rest := getattr(self.simulation, "rest", None):
            rest(mask)

    def wake(self, mask: Mask) -> None:
        """Let the envs of `mask` rest no more; their arms have to be started next."""
        if self._active is not None:
            self.rest(~(self._active | mask))

    def decide(self, actions: NDArray[Any]) -> Outcome:
        """Do the environment steps of one decision. An episode that ends within them is left as it ended."""
        if self._starts.waiting:
            self._record_starts()
        discrete, active = self._discrete, self._active
        self.episodes.action[...] = actions if discrete is None else discrete.decode(actions, self._commands.qpos)
        self.require_finite("action", self.episodes.action, 1)
        return self._step(active) if self._decision_period == 1 else self._repeat(active)

    def require_finite(self, name: str, rows: NDArray[Any], ahead: int = 0) -> None:
        """Raise SimulationDiverged if a number of an env that does not rest is not finite.

        Args:
            name: The name of the numbers, as people know it.
            rows: The numbers, a row for each env.
            ahead: 1 before the step that they are of was measured.
        """
        if is_finite(rows):
            return
        for k in range(self._num_envs) if self._active is None else np.flatnonzero(self._active).tolist():
            step, episode = (int(of[k]) for of in (self.episodes.step, self.episodes.episode))
            require_finite({name: rows[k]}, step + ahead, f" of episode {episode}, env {self.episodes.env[k]:.0f}")

    def state(self) -> TrainingState:
        episodes = self.episodes
        own = {"environment_steps": self.environment_steps, **episodes.state()}
        parts = {**own, **self._starts.state(), **self._commands.state(), **self.events.state()}
        around = prefixed("around.", self.around.state()) if self.around else {}
        told = prefixed("simulation.", self._resumable().state())
        return {**as_state({**parts, **self.shaping.state()}), **around, **told}

    def restore(self, state: TrainingState) -> None:
        episodes = self.episodes
        episodes.restore(state)
        if self.around:
            self.around.restore(under("around.", state))
        self._resumable().restore(under("simulation.", state))
        self.environment_steps = int(state["environment_steps"])
        for part in (self._starts, self._commands, self.events):
            part.restore(state)
        self.shaping.restore(state, episodes.begin_distance)

    def _resumable(self) -> LoggedSimulation:
        if self._log is None:
            raise UsageError("This env does not record the commands of its arms: open it with resumable=True")
        return self._log

    def _repeat(self, given: Mask | None) -> Outcome:
        active = np.ones(self._num_envs, bool) if given is None else given.copy()
        total = self._step(active)
        for _ in range(1, self._decision_period):
            active = active & ~(total.terminated | total.truncated)
            if not active.any():
                break
            ended, carry = self.episodes.matrix[~active], self.shaping.carry
            outcome = self._step(active)
            self.episodes.matrix[~active] = ended
            self.shaping.put_back(~active, carry)
            total = Outcome(
                total.paid + np.where(active, outcome.paid, 0.0),
                total.terminated | (outcome.terminated & active),
                total.truncated | (outcome.truncated & active),
                total.reached | (outcome.reached & active),
                np.where(active, outcome.distance, total.distance),
                total.shaped + np.where(active, outcome.shaped, 0.0),
            )
        self.events.marked |= bool((total.terminated | total.truncated).any())
        return total

    def _step(self, active: Mask | None) -> Outcome:
        """One control period in every env; only `active` ones are recorded (None: all)."""
        episodes, events, around = self.episodes, self.events, self.around
        if events.marked:
            events.forget()
        move = self._commands.advance(around.senses.act(episodes.action, active) if around else episodes.action)
        state, ground = self._commands.drive(self.simulation, move)
        distance = episodes.measure(state)
        self._require_measured()
        episodes.ground[...] = ground
        struck = around.struck() if around else None
        reached = events.judge(distance, ground, struck, move.held)
        episodes.shaped[...] = self.shaping.pay(episodes.steps)
        paid = episodes.shaped + self._step_reward
        if events.marked:
            paid = paid + (episodes.events[:, 0] + episodes.events[:, 1])
        self.require_finite("pay", paid)
        self._record(active)
        episodes.keep()
        if around:
            around.senses.push(active)
        episodes.previous_best[...] = np.minimum(episodes.previous_best, distance)
        ended = episodes.ended.copy()
        outcome = Outcome(paid, ended[0], ended[1], reached, distance, episodes.shaped.copy())
        if self._goes_on and reached.any():
            going_on = reached & ~(ended[0] | ended[1])
            self._set_next_targets(going_on if active is None else going_on & active)
        return outcome

    def _require_measured(self) -> None:
        """Here, since observations are cut off at their bounds: infinity is none any more."""
        if not is_finite(self.episodes.matrix):
            for name, part in self.episodes.parts.items():
                self.require_finite(name, part)

    def _set_next_targets(self, mask: Mask) -> None:
        self._starts.set_next(mask)
        self.events.set_target(mask)
        self.shaping.restart(mask, self.episodes.begin_distance)

    def _record(self, active: Mask | None) -> None:
        self.environment_steps += self._num_envs if active is None else int(active.sum())
        if self.recorder is not None:
            record = self.episodes.record
            self.recorder.append(record if active is None else record[active])

    def _record_starts(self) -> None:
        rows = self._starts.take_rows()
        if self.recorder is not None:
            self.recorder.append(rows)
        self.episodes.step_price[:] = self._step_reward  # of every step to come
