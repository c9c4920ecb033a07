"""The environment: a simulator, a task and a reward as a Gymnasium vector env."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from harness.arrays import Float, Float32, Mask
from harness.env.decisions import REACHED, Decisions
from harness.env.random_streams import Seed
from harness.errors import UsageError
from harness.motion.discrete import Discrete
from harness.motion.motion import Motion
from harness.record.cell import Cell
from harness.record.progress import TrainingState
from harness.record.trace import COLUMN, Recorder
from harness.registry.choice import Choice, Registry, choose
from harness.registry.registry import load_registry
from harness.reward import Reward, Steps
from harness.reward.given import ARM, TASK
from harness.reward.steps import joined, map_steps
from harness.robot import Robot
from harness.robot.robot import load_robot
from harness.simulator import Simulation, Simulator
from harness.task import Task, choose_task

Infos: TypeAlias = dict[str, Any]
Actions: TypeAlias = NDArray[Any]


class ReachVectorEnv(gymnasium.vector.VectorEnv[Float32, Actions, Float]):
    """`num_envs` robots on one reach task, paid by one reward.

    A step is a decision: `task.decision_period` environment steps under one action, fewer where the episode ends
    before. The reward of an environment step is the shaped reward plus the task's event terms; a step pays their sum.
    Each env has its own random stream: what env k meets depends on the seed and k alone, whatever the number of envs,
    the reward or the actions.

    `infos` holds, for every env, ``distance`` [m], to the target that the step was made for (of a task with a
    `harness.goal.Goal` its error), ``reward_shaped`` and
    ``is_success``, whether that target was reached; in the autoreset mode SAME_STEP also ``final_obs``, (num_envs,
    observation_size), whose rows hold where ``_final_obs`` is True.

    Attributes:
        robot: The arm.
        task: What it has to do.
        episodes: Where the episodes stand.
    """

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
        records: Collection[str] = (),
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
            records: Columns that rows have beside the usual ones, ``qvel``; those of the reward's terms they have.
        """
        if autoreset_mode is AutoresetMode.NEXT_STEP:
            raise UsageError("autoreset_mode NEXT_STEP is not offered: take SAME_STEP or DISABLED")
        self.num_envs = num_envs
        self.robot, self.task = robot, task
        self.metadata = {"autoreset_mode": autoreset_mode, "render_modes": ["rgb_array"], "render_fps": 10}
        self.render_mode = "rgb_array"
        self._same_step = autoreset_mode is AutoresetMode.SAME_STEP
        motion = task.motion(robot)
        self._observation = task.observation(robot)
        self._define_spaces(motion)
        self._decisions = Decisions(simulator, robot, task, motion, reward, num_envs, recorder, resumable, records)
        self.episodes = self._decisions.episodes

    @property
    def simulation(self) -> Simulation:
        """The simulation that moves the arms. It may be replaced."""
        return self._decisions.simulation

    @simulation.setter
    def simulation(self, simulation: Simulation) -> None:
        self._decisions.simulation = simulation

    @property
    def reward(self) -> Reward:
        """The reward that pays. Another one that remembers the same may replace it."""
        return self._decisions.shaping.reward

    @reward.setter
    def reward(self, reward: Reward) -> None:
        self._decisions.shaping.reward = reward

    @property
    def recorder(self) -> Recorder | None:
        """Gets one row per env and environment step, and one per episode start."""
        return self._decisions.recorder

    @recorder.setter
    def recorder(self, recorder: Recorder | None) -> None:
        self._decisions.recorder = recorder

    @property
    def environment_steps(self) -> int:
        """Taken so far, in all envs together."""
        return self._decisions.environment_steps

    @environment_steps.setter
    def environment_steps(self, steps: int) -> None:
        self._decisions.environment_steps = steps

    def reset(self, *, seed: Seed = None, options: dict[str, Any] | None = None) -> tuple[Float32, Infos]:
        """Start new episodes in all envs, or in those of the option ``reset_mask``, (num_envs,) of bool.

        Args:
            seed: Of all envs' random streams, or one per env; None goes on with the streams.
            options: See above; others are ignored, as in Gymnasium's own envs.

        Raises:
            UsageError: The mask is none of these envs.
        """
        mask, decisions, episodes = _reset_mask(options or {}, self.num_envs), self._decisions, self.episodes
        decisions.wake(mask)
        if seed is not None:
            decisions.seed(seed)
        decisions.start(mask)
        infos = {
            "distance": episodes.distance.copy(),
            "reward_shaped": episodes.shaped.copy(),
            "is_success": episodes.flags[:, REACHED] > 0.0,
        }
        return self._observe(), infos

    def step(self, actions: Actions) -> tuple[Float32, Float, Mask, Mask, Infos]:  # type: ignore[override]
        """One decision in every env."""
        decisions = self._decisions
        outcome = decisions.decide(actions)
        infos = {"distance": outcome.distance, "reward_shaped": outcome.shaped, "is_success": outcome.reached}
        if self._same_step and decisions.events.marked:
            ended = outcome.terminated | outcome.truncated
            if ended.any():
                infos["final_obs"], infos["_final_obs"] = self._observe(), ended
                decisions.start(ended)
        return self._observe(), outcome.paid, outcome.terminated, outcome.truncated, infos

    def rest(self, mask: Mask) -> None:
        """Leave the envs of `mask`, (num_envs,), as they are until they are reset: nothing of them is recorded.

        What a step returns of them means nothing. The autoreset mode has to be DISABLED.
        """
        self._decisions.rest(mask)

    def state(self) -> TrainingState:
        """Everything that `restore` needs, between two steps.

        Raises:
            UsageError: The env was opened without ``resumable=True``.
        """
        return self._decisions.state()

    def restore(self, state: TrainingState) -> None:
        """Go on from the `state` that an env of the same kind returned, in the middle of episodes too.

        Raises:
            UsageError: The env was opened without ``resumable=True``.
            SchemaError: The simulator does not bring the arms where they stood. The env has to be reset with a seed.
        """
        self._decisions.restore(state)

    def render(self) -> tuple[NDArray[np.uint8], ...]:
        """One RGB frame of every env, each (480, 640, 3)."""
        return tuple(self.simulation.render(k, self.episodes.target[k], 640, 480) for k in range(self.num_envs))

    def close_extras(self, **kwargs: Any) -> None:
        """Close the simulator. The recorder belongs to the caller."""
        self.simulation.close()

    def _define_spaces(self, motion: Motion) -> None:
        spaces, batch = gymnasium.spaces, gymnasium.vector.utils.batch_space
        self.single_observation_space = spaces.Box(self._observation.low, self._observation.high)
        self.single_action_space = (
            spaces.Discrete(motion.choices)
            if isinstance(motion, Discrete)
            else spaces.Box(-1.0, 1.0, (motion.action_size,), np.float32)
        )
        self.observation_space = batch(self.single_observation_space, self.num_envs)
        self.action_space = batch(self.single_action_space, self.num_envs)

    def _observe(self) -> Float32:
        around = self._decisions.around
        seen = self._observation.observe(around.senses.look() if around else self.episodes)
        self._decisions.require_finite("observation", seen)
        return seen


def _reset_mask(options: dict[str, Any], num_envs: int) -> Mask:
    """Which envs `reset` is for, (num_envs,)."""
    mask = np.asarray(options.get("reset_mask", np.ones(num_envs, bool)))
    if mask.shape != (num_envs,) or mask.dtype != bool:
        raise UsageError(f"The option reset_mask is {mask.dtype} of shape {mask.shape}: give bool of ({num_envs},)")
    return mask


Given: TypeAlias = str | Mapping[str, Any]
"""``"arp:k2=2"`` or ``{"name": "arp", "k2": 2}``."""


ARMS_BYTES = 2**28
"""What the arms of a batch take at most, where a simulator says what one takes."""


@dataclass(frozen=True)
class World:
    """Everything that an environment is made of. It is built once and opened as often as needed.

    Attributes:
        simulator: Whose engine moves the arms.
        robot: The arm.
        task: What it has to do.
        reward: What it is paid for.
        records: What rows have beside the usual columns.
    """

    simulator: Simulator
    robot: Robot
    task: Task
    reward: Reward
    records: tuple[str, ...] = ()

    def open(self, num_envs: int, **options: Any) -> ReachVectorEnv:
        """An environment of `num_envs` arms; `options` go to `harness.env.vector_env.ReachVectorEnv`."""
        return ReachVectorEnv(
            self.simulator, self.robot, self.task, self.reward, num_envs, records=self.records, **options
        )

    def batches(self, arms: int, most: int | None = None) -> list[slice]:
        """Which of so many arms are open at once, one batch after the other, where each one's episode is its own.

        All of them, unless the simulator's class variable ``arm_bytes`` says that an arm takes much memory.

        Args:
            arms: How many, >= 1.
            most: As many in a batch at most, whatever they take; None for any number.
        """
        cost = getattr(self.simulator, "arm_bytes", 0)
        at_once = min(most or arms, max(ARMS_BYTES // cost, 1) if cost else arms)
        return [slice(begin, min(begin + at_once, arms)) for begin in range(0, arms, at_once)]

    def open_part(self, batch: slice, recorder: Recorder | None = None) -> ReachVectorEnv:
        """The envs of a batch, which are reset one by one; see `batches`.

        They meet what they meet among all envs, under the same numbers.
        """
        env = self.open(batch.stop - batch.start, recorder=recorder, autoreset_mode=AutoresetMode.DISABLED)
        env.episodes.env[:] = range(batch.start, batch.stop)
        return env


def build_world(cell: Cell, robot: Robot, registry: Registry) -> World:
    """The world of a cell's episodes.

    Args:
        cell: Whose simulator, task and reward.
        robot: The cell's, loaded.
        registry: The plugins.

    Raises:
        UsageError: Something is not installed any more, or does not take its parameters.
    """
    return World(
        cell.simulator.build(registry, "simulators"),
        robot,
        cell.task.build(registry, "tasks"),
        cell.reward.build(registry, "rewards"),
        cell.records,
    )


def make_env(
    simulator: Given = "mujoco",
    task: Given = "fd100-reach",
    reward: Given = "baseline",
    robot: str | Path | None = None,
    num_envs: int = 1,
    autoreset_mode: AutoresetMode = AutoresetMode.SAME_STEP,
) -> ReachVectorEnv:
    """The vector env of one combination.

    Args:
        simulator: Its name, with parameters if need be, ``mujoco:drive=servo``; or a mapping with the key ``name``.
        task: The same.
        reward: The same.
        robot: A registered name, or the path of a folder or a URDF; None: the robot that the task was made for.
        num_envs: How many arms, at least 1.
        autoreset_mode: When an episode that ended makes room for the next one.

    Raises:
        UsageError: A name or a parameter is not known, or they do not go together.
    """
    if num_envs < 1:
        raise UsageError(f"num_envs={num_envs}: must be at least 1")
    registry = load_registry()

    def build(kind: str, given: Given) -> Any:
        choice: Choice = choose(registry, kind, given)
        return choice.build(registry, kind)

    goal, arm = choose_task(registry, task, robot, partial(load_robot, registry=registry))
    world = World(build("simulators", simulator), arm, goal.build(registry, "tasks"), build("rewards", reward))
    return world.open(num_envs, autoreset_mode=autoreset_mode)


Action = NDArray[Any]
PRICES = slice(COLUMN["reward_ground"], COLUMN["reward_step"] + 1)
"""What the task pays, in a row: for the ground, for the target, and for the step."""


class ReachEnv(gymnasium.Env[Float32, Action]):
    """A `ReachVectorEnv` of one env, without its leading axis.

    The info of a step also holds, under `ARM`, what an arm's reward is given, a row for each environment step; under
    `TASK` what the task paid beside the reward.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10, ARM: True}  # noqa: RUF012 (Gymnasium declares it so)

    def __init__(
        self,
        simulator: Given = "mujoco",
        task: Given = "fd100-reach",
        reward: Given = "baseline",
        robot: str | Path | None = None,
        render_mode: str | None = None,
    ) -> None:
        if render_mode not in {None, *self.metadata["render_modes"]}:
            raise UsageError(
                f"render_mode {render_mode!r}: the env itself draws 'rgb_array' or nothing. "
                "gymnasium.make(..., render_mode='human') opens a window around it, which takes "
                "pip install 'gymnasium[classic-control]'"
            )
        self.vector_env = make_env(simulator, task, reward, robot, autoreset_mode=AutoresetMode.DISABLED)
        self.observation_space = self.vector_env.single_observation_space
        self.action_space = self.vector_env.single_action_space
        self.render_mode = render_mode
        self.vector_env.recorder = self
        self._taken, self._paid = list[Steps](), 0.0

    def append(self, rows: Float) -> None:
        """Note an environment step while the env still tells what was before it; it calls this, as of any recorder."""
        if rows[0, COLUMN["step"]]:
            self._taken.append(map_steps(np.ndarray.copy, self.vector_env.episodes.steps))
            self._paid += rows[0, PRICES].sum().item()

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Float32, dict[str, Any]]:
        """Start an episode; see `ReachVectorEnv.reset`."""
        super().reset(seed=seed)
        observations, infos = self.vector_env.reset(seed=seed, options=options)
        return observations[0], _first(infos)

    def step(self, action: Action) -> tuple[Float32, float, bool, bool, dict[str, Any]]:
        """One control period; see `ReachVectorEnv.step`."""
        self._taken, self._paid = [], 0.0
        observations, rewards, terminated, truncated, infos = self.vector_env.step(np.asarray(action)[None])
        taken = joined(self._taken) if self._taken[1:] else self._taken[0]
        told = {**_first(infos), ARM: taken, TASK: self._paid}
        return observations[0], float(rewards[0]), bool(terminated[0]), bool(truncated[0]), told

    def render(self) -> NDArray[np.uint8] | None:
        """One RGB frame, (480, 640, 3), in the render mode ``rgb_array``."""
        return self.vector_env.render()[0] if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """Close the simulator."""
        self.vector_env.close()


def _first(infos: dict[str, Any]) -> dict[str, Any]:
    return {key: values[0].item() for key, values in infos.items()}
