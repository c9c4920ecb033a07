"""A step of the env without Gymnasium: arms side by side, each in an episode, are moved, paid and recorded."""

from collections.abc import Collection
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.conditions import conditions_of
from harness.env.commands import Commands
from harness.env.episodes import Episodes
from harness.env.events import Events
from harness.env.logged_simulation import LoggedSimulation
from harness.env.random_streams import Seed
from harness.env.shaping import Shaping
from harness.env.starts import Starts
from harness.env.surroundings import Surroundings, extra_columns
from harness.errors import UsageError
from harness.motion import Discrete, Motion
from harness.progress import TrainingState, as_state, prefixed, under
from harness.record.trace import QVEL, TERM, Recorder
from harness.reward import Reward
from harness.reward.needs import terms_of
from harness.robot import Robot
from harness.simulator import Simulation, Simulator
from harness.task import Task, goal_of


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
        """Open the simulator; see `harness.env.ReachVectorEnv`."""
        self._num_envs, conditions = num_envs, conditions_of(task)
        # Asked for once: a task may be a dataclass with checks, and these are read in every step.
        self._decision_period, self._goes_on = task.decision_period, not task.ends_at_target
        self._step_reward = np.array(task.step_reward, float)  # as an array: numpy turns a float into one at every call
        terms = terms_of(reward, robot.dof, motion.action_size)
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
        return self._step(active) if self._decision_period == 1 else self._repeat(active)

    def state(self) -> TrainingState:
        """See `harness.env.ReachVectorEnv`."""
        episodes = self.episodes
        own = {"environment_steps": self.environment_steps, **episodes.state()}
        parts = {**own, **self._starts.state(), **self._commands.state(), **self.events.state()}
        around = prefixed("around.", self.around.state()) if self.around else {}
        told = prefixed("simulation.", self._resumable().state())
        return {**as_state({**parts, **self.shaping.state()}), **around, **told}

    def restore(self, state: TrainingState) -> None:
        """See `harness.env.ReachVectorEnv`."""
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
        episodes.ground[...] = ground
        episodes.shaped[...] = self.shaping.pay(episodes.steps)
        struck = around.struck() if around else None
        reached, terminated, truncated = events.judge(distance, ground, struck, move.held)
        paid = episodes.shaped + self._step_reward
        if events.marked:
            paid = paid + (episodes.events[:, 0] + episodes.events[:, 1])
        self._record(active)
        episodes.keep()
        if around:
            around.senses.push(active)
        episodes.previous_best[...] = np.minimum(episodes.previous_best, distance)
        outcome = Outcome(paid, terminated, truncated, reached, distance, episodes.shaped.copy())
        if self._goes_on and reached.any():
            going_on = reached & ~(terminated | truncated)
            self._set_next_targets(going_on if active is None else going_on & active)
        return outcome

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
