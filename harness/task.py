"""The interface of a task: start, target, what the learner sees and does, when an episode ends."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from harness.arrays import Float, Float32, Mask
from harness.face import face_of
from harness.goal import Goal as Goal, Situation as Situation
from harness.motion.modes import build_motion as build_motion
from harness.motion.motion import Motion as Motion, Setting as Setting
from harness.registry.choice import Choice, Registry, choose
from harness.robot import Robot
from harness.robot.robot import load_robot

if TYPE_CHECKING:
    from harness.env.episodes import Episodes
    from harness.env.reach_task import ReachTask as ReachTask, place_box as place_box
else:
    __all__, __getattr__ = face_of(__name__, "LONGEST_EPISODE", "Observation", "Targets", "Task")

LONGEST_EPISODE = 1_000_000_000
"""The most steps of an episode: as many as a training may have."""


class Targets(NamedTuple):
    """Targets that were drawn in advance."""

    position: Float
    """(count, 3), [m]."""
    relative: Mask
    """Where a position counts from, (count,). True: from the end effector at the time the target is set. False: from
    the world's origin."""


class Observation(Protocol):
    """Turns the state of the episodes into what the learner sees."""

    @property
    def low(self) -> Float32:
        """Lower bounds, (size,)."""

    @property
    def high(self) -> Float32:
        """Upper bounds, (size,)."""

    def observe(self, episodes: "Episodes") -> Float32:
        """What the learner sees of every episode, (num_envs, size), a new array.

        Args:
            episodes: Their state, not to be changed: `qpos` and `qvel`, (num_envs, dof), [rad] and [rad/s];
                `end_effector`, `target` and `offset`, which leads from the one to the other, (num_envs, 3), world
                frame, [m]; `distance`, (num_envs,), [m], or a goal's error; `action`, the last one, (num_envs,
                action_size); `numbers`, what a goal draws beside the target's position.
        """


class Task(Protocol):
    """A frozen dataclass whose fields are the task's parameters. `harness.task.ReachTask` is one.

    An environment step is one control period. The learner decides every `decision_period` environment steps. Its action
    is repeated in between, and every environment step pays a reward.

    A task may also have three more members. ``varies`` is False if all episodes have the same start and targets, see
    `varies`. ``goal(robot)`` returns a `Goal` if more counts than the end effector's distance to the target.
    ``defaults_for(robot)`` returns values of parameters, by name, that take the place of the defaults for that arm, see
    `choose_task`.
    """

    @property
    def robot(self) -> str:
        """Registered name of the arm that the task was made for. It is used if no other robot is named."""

    @property
    def epsilon(self) -> float:
        """The target is reached within this distance [m], NOTE eq. 20; in a task with a `Goal`, within this error."""

    @property
    def ends_at_target(self) -> bool:
        """Whether reaching the target ends the episode; if not, the next target is set."""

    @property
    def horizon(self) -> int:
        """An episode is truncated after this many environment steps."""

    @property
    def control_period(self) -> float:
        """Duration of an environment step, [s]."""

    @property
    def decision_period(self) -> int:
        """Environment steps per decision."""

    @property
    def ground_reward(self) -> float:
        """Paid when the arm touches the ground, which ends the episode, NOTE eq. 18."""

    @property
    def step_reward(self) -> float:
        """Paid on every environment step."""

    def target_rewards(self, robot: Robot, qpos: Float) -> Float:
        """What reaching the target pays with the joints at `qpos`, (count, dof): (count,), NOTE eq. 19."""

    @property
    def action(self) -> str:
        """The action mode with its parameters, see `harness.motion`."""

    @property
    def speed(self) -> float:
        """Fraction of a joint's maximum speed that may be used, NOTE Table I."""

    @property
    def acceleration(self) -> float:
        """The same for the acceleration."""

    def motion(self, robot: Robot) -> Motion:
        """How actions move `robot`: the A of the NOTE's tuple <S, A, T, R>."""

    def observation(self, robot: Robot) -> Observation:
        """What the learner sees of `robot`: the S of the tuple."""

    def check(self, robot: Robot) -> None:
        """Check whether `robot` can do the task.

        Raises:
            UsageError: It cannot.
        """

    def draw_start(self, robot: Robot, rng: np.random.Generator) -> Float:
        """Joint positions at the start of an episode, (dof,), within the joint ranges."""

    def draw_targets(self, robot: Robot, rng: np.random.Generator, count: int) -> Targets:
        """Targets of the next `count` episodes.

        Raises:
            UsageError: The arm reaches almost none of them.
        """

    def start_in_words(self, robot: Robot) -> str:
        """Where an episode starts, in one line for ``harness describe``."""

    def target_in_words(self, robot: Robot) -> str:
        """What the target is, in one line."""

    def target_reward_in_words(self) -> str:
        """What reaching the target pays, in one line."""


def varies(task: Task) -> bool:
    """Whether episodes differ in start or targets. They do if the task has no ``varies``.

    If they do not differ, all deterministic episodes of a policy are the same, so an evaluation does only one.
    """
    return bool(getattr(task, "varies", True))


def choose_task(
    registry: Registry,
    given: str | Mapping[str, Any],
    robot: str | Path | None = None,
    load: Callable[[Any], Robot] = load_robot,
) -> tuple[Choice, Robot]:
    """The task that a user named, and the arm that does it.

    What the user did not choose has the default that the task declares for the arm. Like all that is chosen, it stands
    in the choice as a number.

    Args:
        registry: The plugins.
        given: The task's name, with the parameters that the user chose.
        robot: Name or path of the arm; None for the task's own.
        load: Finds the arm.

    Raises:
        UsageError: A name or a parameter is not known.
        PluginError: The plugin of the task is broken.
    """
    plain = choose(registry, "tasks", given)
    task = plain.build(registry, "tasks")
    arm = load(robot or task.robot)
    if not hasattr(task, "defaults_for"):
        return plain, arm
    return choose(registry, "tasks", given, lambda built: built.defaults_for(arm)), arm


def goal_of(task: Task, robot: Robot) -> Goal | None:
    """What `task` asks of `robot`; None if it only asks to bring the end effector to a point that does not move."""
    goal = getattr(task, "goal", None)
    return None if goal is None else goal(robot)
