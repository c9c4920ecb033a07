"""An arm's task as a search plays it: all episodes of a call at once, paid as a training is."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from types import MappingProxyType
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode

from harness import Float, Ints, Mask
from harness.env.arm_observation import kinematics_policy, why_not_kinematics
from harness.env.vector_env import ReachVectorEnv, World as Arm
from harness.log.log import SUCCESS
from harness.motion.motion import MoveJ
from harness.payoff.rollout import SCRIPTS, plan_actions
from harness.record.trace import TERM
from harness.task import goal_of

from .world import REWARD, Beginning, Shown, Space, Step, World

DISTANCE, CLOSEST, GROUND, TARGETS = "distance", "closest", "ground", "targets"
EVENTS = "events"
ENV, STEP = 0, 2
"""The columns of a recorded row that name the arm, and count the steps of an episode; see `harness.record.trace`."""
PRICES = ("reward_ground", "reward_target", "reward_step")
"""The columns of what a task pays beside the reward."""
DRAWN = {"qpos": ("qpos",), "target": ("target_x", "target_y", "target_z"), "distance": ("distance",)}
"""The columns of a recorded row that an arm is drawn from."""


class ArmWorld(World):
    """One reward on one task of an arm; see `World`.

    An episode of a task that goes on at a target is a success from its first target on. The measures are ``distance``,
    the last one to the target, ``closest``, the smallest one, both in [m] or in the error of the task's goal;
    ``ground``, whether it ended there; and ``targets``, how many were reached, of a task that goes on.
    """

    directions: Mapping[str, int] = MappingProxyType({DISTANCE: -1, CLOSEST: -1, GROUND: -1, TARGETS: 1})
    together = 256
    success = SUCCESS

    def __init__(self, arm: Arm, name: str, reward: str, gamma: float) -> None:
        """Take what the simulator is opened with.

        Args:
            arm: Simulator, robot, task and reward.
            name: What the task is called.
            reward: The label of the reward.
            gamma: The learner's discount per step.

        Raises:
            UsageError: The robot cannot do the task.
        """
        arm.task.check(arm.robot)
        self.arm, self.name, self.reward, self.gamma = arm, name, reward, gamma
        self.period = arm.task.decision_period
        self.horizon = -(-arm.task.horizon // self.period)
        self.measures = (DISTANCE, CLOSEST, GROUND, *(() if arm.task.ends_at_target else (TARGETS,)))
        self._batches: dict[int, _Arms] = {}

    @cached_property
    def space(self) -> Space:  # type: ignore[override]
        """The space of one action."""
        space: Any = self.open(1).env.single_action_space
        found: Space = space
        return found

    @cached_property
    def observes(self) -> gymnasium.Space[Any]:  # type: ignore[override]
        """The space of what policies are given."""
        return self.open(1).env.single_observation_space

    @cached_property
    def terms(self) -> Sequence[str]:  # type: ignore[override]
        """The names of the terms, and the task's events."""
        return (*(name.removeprefix(TERM) for name in self.open(1).terms), EVENTS)

    def open(self, count: int) -> "_Arms":
        """At least so many arms, the next power of two, so that few are opened; see `World`."""
        size = 1 << (count - 1).bit_length()
        if size not in self._batches:
            self._batches[size] = _Arms(self.arm.open(size, autoreset_mode=AutoresetMode.DISABLED))
        return self._batches[size]

    def close(self) -> None:
        """Close the simulators."""
        for batch in self._batches.values():
            batch.close()
        self._batches.clear()

    def successes(self, told: Float) -> Mask:
        """From the first target on; see `World`."""
        found: Mask = told[:, -1] > 0.0
        return found

    def nearest(self, shown: Shown) -> tuple[float, Sequence[Float]]:
        """By the smallest distance; see `World`."""
        return -float(shown.measures[CLOSEST][-1]), ()

    def drawn(self) -> Mapping[str, Float]:
        """What its one arm is drawn from; see `World`."""
        rows, dof = np.array(self.open(1).drawn), self.arm.robot.dof
        time = np.arange(len(rows), dtype=np.float64) * (self.arm.task.control_period * self.period)
        return {"time": time[:, np.newaxis], **dict(zip(DRAWN, np.split(rows, [dof, dof + 3], axis=1), strict=True))}

    def distinct(self, starts: Sequence[int]) -> tuple[int, ...]:
        """Those starts that differ: a task may begin all its episodes alike."""
        _, first = np.unique(np.hstack(self._places(starts)), axis=0, return_index=True)
        return tuple(starts[place] for place in np.sort(first).tolist())

    def scripts(self, starts: Sequence[int]) -> Sequence[Beginning]:
        """What its own kinematics do; and the scripted movements from each start, but the random one; see `World`.

        None where a task asks for more than points, or its actions are of another kind: scripts move joints.
        """
        robot, task, found = self.arm.robot, self.arm.task, list[Beginning]()
        if not why_not_kinematics(task, robot):
            policy = kinematics_policy(task, robot)
            found.append(Beginning("inverse kinematics", act=lambda seen: policy.act(seen[np.newaxis])[0]))
        if goal_of(task, robot) is not None or not isinstance(task.motion(robot), MoveJ):
            return found
        qpos, target = self._places(starts)
        for script in SCRIPTS[:-1]:
            planned = plan_actions(script, robot, task, qpos, target, np.random.default_rng(0))
            found.append(Beginning(f"script {script}", [*planned[:: self.period].swapaxes(0, 1)]))
        return found

    def _places(self, starts: Sequence[int]) -> tuple[Float, Float]:
        """Where arms stand at starts: joint positions, (n, dof), and targets, (n, 3) [m] in the world frame."""
        found = list[tuple[Float, Float]]()
        for some in self._parts(starts):
            batch, count = self.open(len(starts[some])), len(starts[some])
            batch.reset(list(starts[some]))
            found.append((batch.env.simulation.read().qpos[:count].copy(), batch.env.episodes.target[:count].copy()))
        qpos, target = map(np.concatenate, zip(*found, strict=True))
        return qpos, target

    def _parts(self, starts: Sequence[int] | Ints) -> list[slice]:
        return self.arm.batches(len(starts), self.together)


class _Arms:
    """Arms side by side; see `Batch`. It is told every row that is recorded.

    Attributes:
        env: What moves them.
        terms: The columns of the terms of the reward.
        drawn: What one alone is drawn from, at the start and after each step, (size,).
    """

    def __init__(self, env: ReachVectorEnv) -> None:
        self.env, at = env, env.episodes.columns
        env.recorder = self
        self.terms = [name for name in env.episodes.extras if name.startswith(TERM)] or [REWARD]
        self._paid_by, self._drawn_from = at(*self.terms, *PRICES), at(*(name for of in DRAWN.values() for name in of))
        self._sums = np.zeros((env.num_envs, len(self._paid_by)))
        self.drawn: list[Float] = []

    def reset(self, starts: list[int]) -> tuple[Any, Any]:
        count, env = self.env.num_envs, self.env
        seen, infos = env.reset(seed=[*starts, *starts[:1] * (count - len(starts))])
        self._running = np.arange(count) < len(starts)
        if not self._running.all():
            env.rest(~self._running)
        self._closest, self._targets = infos[DISTANCE].copy(), np.zeros(count)
        self.drawn = [env.episodes.record[0, self._drawn_from]]
        return seen[: len(starts)], seen

    def append(self, rows: Float) -> None:
        """Add up what a decision pays; see `harness.record.trace.Recorder`."""
        if rows[0, STEP]:  # no starts
            self._sums[rows[:, ENV].astype(np.intp)] += rows[:, self._paid_by]
            self.drawn[-1] = rows[0, self._drawn_from]

    def step(self, actions: Any) -> Step:
        env, count = self.env, len(actions)
        given = np.asarray(actions, env.single_action_space.dtype)
        self._sums[:] = 0.0
        self.drawn.append(self.drawn[-1])
        seen, paid, terminated, truncated, infos = env.step(np.resize(given, (env.num_envs, *given.shape[1:])))
        self._closest, self._targets = np.minimum(self._closest, infos[DISTANCE]), self._targets + infos["is_success"]
        ended, over = dict[int, str](), self._running & (terminated | truncated)
        if over.any():
            ended = {int(k): "terminated" if terminated[k] else "truncated" for k in np.flatnonzero(over)}
            self._running &= ~over
            if self._running.any():
                env.rest(~self._running)
        terms, events = self._sums[:, : len(self.terms)].T, self._sums[:, len(self.terms) :].sum(axis=1)
        told = (infos[DISTANCE], self._closest, env.episodes.flags[:, 0], self._targets)
        return Step(
            given,
            seen[:count],
            seen,
            np.array([paid, *terms, events]).T,
            np.array(told).T,
            ended,
        )

    def close(self) -> None:
        self.env.close()
