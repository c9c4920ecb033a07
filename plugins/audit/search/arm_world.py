"""An arm's task as a search plays it: all episodes of a call at once, paid as a training is."""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from types import MappingProxyType
from typing import Any, TypeAlias

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from harness.arrays import Float, Ints, Mask
from harness.authoring.commands import TERM, ReachVectorEnv
from harness.env import World as Arm
from harness.log import SUCCESS, episode_sum

from .world import Act, Actions, Outcomes, Shown, Space

TOGETHER = 256
"""The most arms that move side by side."""
DISTANCE, CLOSEST, GROUND, TARGETS = "distance", "closest", "ground", "targets"
IS_SUCCESS, PAID, REWARD, EVENTS = "is_success", "paid", "reward", "events"
STEP = 2
"""The column of a recorded row that counts the steps of an episode; see `harness.record.trace`."""
PRICES = ("reward_ground", "reward_target", "reward_step")
"""The columns of what a task pays beside the reward."""
DRAWN = {"qpos": ("qpos",), "target": ("target_x", "target_y", "target_z"), "distance": ("distance",)}
"""The columns of a recorded row that an arm is drawn from."""
DIRECTIONS: Mapping[str, int] = MappingProxyType({DISTANCE: -1, CLOSEST: -1, GROUND: -1, TARGETS: 1})
Choose: TypeAlias = Callable[[int, NDArray[Any], Mask], NDArray[Any]]
"""From the number of a step, the arms' observations, and which of them are in an episode, to an action of each."""


class ArmWorld:
    """One reward on one task of an arm; see `World`.

    An episode of a task that goes on at a target is a success from its first target on. The measures are ``distance``,
    the last one to the target, ``closest``, the smallest one, both in [m] or in the error of the task's goal;
    ``ground``, whether it ended there; and ``targets``, how many were reached, of a task that goes on.
    """

    directions = DIRECTIONS
    notes: Sequence[str] = ()
    together = TOGETHER
    success = SUCCESS

    def __init__(self, arm: Arm, name: str, reward: str, gamma: float) -> None:
        """Open the simulator.

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
        self.horizon = -(-arm.task.horizon // arm.task.decision_period)
        self.taken = 0
        self._envs: dict[int, ReachVectorEnv] = {}

    @property
    def space(self) -> Space:
        """The space of one action."""
        space: Any = self._env(1).single_action_space
        found: Space = space
        return found

    @property
    def observes(self) -> gymnasium.Space[Any]:
        """The space of what policies are given."""
        return self._env(1).single_observation_space

    @cached_property
    def is_repeated(self) -> bool:
        """Whether an engine that has moved since, and a new one, do the same again."""
        self.space.seed(0)
        actions = np.stack([self.space.sample() for _ in range(self.horizon)])
        shown = [self.show(0, actions) for _ in range(2)]
        self.close()
        shown.append(self.show(0, actions))
        return all(np.array_equal(shown[0].paid, other.paid) for other in shown[1:])

    def play(self, starts: Ints, actions: Actions) -> Outcomes:
        """Play n episodes of given actions; see `World`."""
        return _joined([
            self._play(starts[some], lambda step, *_, some=some: actions[some, step])
            for some in _parts(len(starts))
        ])  # fmt: skip

    def act(self, starts: Ints, policy: Act) -> tuple[Outcomes, list[Actions]]:
        """Play n episodes of a policy; see `World`."""
        parts, taken = [], list[Actions]()
        for some in _parts(len(starts)):
            chosen: list[NDArray[Any]] = []

            def choose(step: int, seen: NDArray[Any], running: Mask, chosen: list[NDArray[Any]] = chosen) -> Any:
                actions = np.zeros((len(seen), *(self.space.shape or ())), self.space.dtype)
                for k in np.flatnonzero(running):
                    actions[k] = policy(seen[k])
                chosen.append(actions)
                return actions

            parts.append(self._play(starts[some], choose))
            taken += [np.stack([row[k] for row in chosen[:steps]]) for k, steps in enumerate(parts[-1].steps.tolist())]
        return _joined(parts), taken

    def show(self, start: int, actions: Actions) -> Shown:
        """Play one episode and keep everything; see `World`."""
        env = self._env(1)
        names = [name for name in env.episodes.extras if name.startswith(TERM)] or [REWARD]
        rows, steps, ended = _Rows(), list[tuple[Float, dict[str, Any]]](), ""
        env.recorder = rows
        try:
            begun = float(env.reset(seed=[start])[1][DISTANCE][0])
            for action in actions[: self.horizon]:
                _, paid, terminated, truncated, infos = env.step(action[np.newaxis])
                steps.append((rows.take(), {**infos, PAID: paid, GROUND: env.episodes.flags[:, 0].copy()}))
                if terminated[0] or truncated[0]:
                    ended = "terminated" if terminated[0] else "truncated"
                    break
        finally:
            env.recorder = None
        self.taken += len(steps) * self.arm.task.decision_period
        of_step = {name: env.episodes.columns(name) for name in (*names, *PRICES)}
        part = {name: np.array([row[:, at].sum() for row, _ in steps]) for name, at in of_step.items()}
        terms = {name.removeprefix(TERM): part[name] for name in names}
        asked = (PAID, DISTANCE, IS_SUCCESS, GROUND)
        told = {name: np.array([float(info[name][0]) for _, info in steps]) for name in asked}
        reached = told.pop(IS_SUCCESS)
        measures = {
            **told,
            CLOSEST: np.minimum(begun, np.minimum.accumulate(told[DISTANCE])),
            TARGETS: np.cumsum(reached),
        }
        return Shown(
            start,
            np.asarray(actions[: len(steps)]),
            told[PAID],
            {**terms, EVENTS: np.sum([part[name] for name in PRICES], axis=0)},
            np.maximum.accumulate(reached) > 0.0,
            {name: values for name, values in measures.items() if name in self._measures},
            ended or "cut",
            drawn=rows.drawn(env),
        )

    def places(self, starts: Ints) -> tuple[Float, Float]:
        """Where arms stand at starts: joint positions, (n, dof), and targets, (n, 3) [m] in the world frame."""
        env = self._env(len(starts))
        env.reset(seed=_padded(starts, env.num_envs).tolist())
        return env.simulation.read().qpos[: len(starts)].copy(), env.episodes.target[: len(starts)].copy()

    def distinct(self, starts: Sequence[int]) -> tuple[int, ...]:
        """Those starts that differ: a task may begin all its episodes alike."""
        found: dict[bytes, int] = {}
        for start, qpos, target in zip(starts, *self.places(np.array(starts)), strict=True):
            found.setdefault(qpos.tobytes() + target.tobytes(), start)
        return tuple(found.values())

    def watch(self, start: int, policy: Act) -> Shown:
        """Play one episode of a policy and keep everything but what it observed; see `World`."""
        return self.show(start, self.act(np.array([start]), policy)[1][0])

    def close(self) -> None:
        """Close the simulators."""
        for env in self._envs.values():
            env.close()
        self._envs.clear()

    @property
    def _measures(self) -> tuple[str, ...]:
        return DISTANCE, CLOSEST, GROUND, *(() if self.arm.task.ends_at_target else (TARGETS,))

    def _env(self, count: int) -> ReachVectorEnv:
        """An env of at least so many arms; the next power of two, so that few are opened."""
        size = 1 << (count - 1).bit_length()
        if size not in self._envs:
            self._envs[size] = self.arm.open(size, autoreset_mode=AutoresetMode.DISABLED)
        return self._envs[size]

    def _play(self, starts: Ints, choose: Choose) -> Outcomes:
        """Play at most `TOGETHER` episodes."""
        env, count = self._env(len(starts)), len(starts)
        observations, infos = env.reset(seed=_padded(starts, env.num_envs).tolist())
        running = np.arange(env.num_envs) < count
        if count < env.num_envs:
            env.rest(~running)
        steps, reached, first = (np.zeros(env.num_envs, np.int64) for _ in range(3))
        paid, ground = list[Float](), np.zeros(env.num_envs)
        distance, closest = infos[DISTANCE].copy(), infos[DISTANCE].copy()
        for step in range(self.horizon):
            actions = choose(step, observations[:count], running[:count])
            observations, pay, terminated, truncated, infos = env.step(_padded(actions, env.num_envs))
            paid.append(pay[:count])
            steps += running
            reached += running & infos[IS_SUCCESS]
            first = np.where((first == 0) & (reached > 0), step + 1, first)
            distance = np.where(running, infos[DISTANCE], distance)
            closest = np.minimum(closest, distance)
            ended = running & (terminated | truncated)
            if ended.any():
                ground = np.where(ended, env.episodes.flags[:, 0], ground)
                running &= ~ended
                if not running.any():
                    break
                env.rest(~running)
        self.taken += int(steps.sum()) * self.arm.task.decision_period
        success = reached > 0
        earned = [of[:length] for of, length in zip(np.array(paid).T, steps.tolist(), strict=False)]
        found = {DISTANCE: distance, CLOSEST: closest, GROUND: ground, TARGETS: reached.astype(float)}
        return Outcomes(
            steps[:count],
            np.array([episode_sum(of) for of in earned]),
            np.array([episode_sum(of, self.gamma) for of in earned]),
            success[:count],
            np.where(success, first, self.horizon)[:count],
            np.where(success, (steps - first + 1) / np.maximum(steps, 1), 0.0)[:count],
            -closest[:count],
            {name: found[name][:count] for name in self._measures},
        )


class _Rows:
    """Keeps copies of the rows of the steps that follow."""

    def __init__(self) -> None:
        self._rows: list[Float] = []
        self._drawn: list[Float] = []

    def append(self, rows: Float) -> None:
        """Take rows, (1, width)."""
        self._rows.append(rows.copy())

    def drawn(self, env: ReachVectorEnv) -> dict[str, Float]:
        """What the arm is drawn from, at the start and after each step; see `Shown`."""
        rows = np.concatenate(self._drawn)
        time = np.arange(len(rows), dtype=np.float64) * (env.task.control_period * env.task.decision_period)
        return {"time": time[:, np.newaxis], **{name: rows[:, env.episodes.columns(*of)] for name, of in DRAWN.items()}}

    def take(self) -> Float:
        """Those since the last call, but those of starts, (steps, width)."""
        rows, self._rows = np.concatenate(self._rows), []
        self._drawn += [rows[:1], rows[-1:]] if not self._drawn else [rows[-1:]]
        found: Float = rows[rows[:, STEP] > 0.0]
        return found


def _parts(count: int) -> list[slice]:
    return [slice(at, min(at + TOGETHER, count)) for at in range(0, count, TOGETHER)]


def _padded(rows: NDArray[Any], count: int) -> NDArray[Any]:
    """So many rows, of which those that lack are the first."""
    return np.concatenate([rows, np.repeat(rows[:1], count - len(rows), axis=0)]) if len(rows) < count else rows


def _joined(parts: Sequence[Outcomes]) -> Outcomes:
    """Outcomes one after the other."""
    names = ("steps", "paid", "discounted", "success", "time", "share", "near")
    whole: dict[str, Any] = {name: np.concatenate([getattr(it, name) for it in parts]) for name in names}
    measures = {name: np.concatenate([it.measures[name] for it in parts]) for name in parts[0].measures}
    return Outcomes(**whole, measures=measures)
