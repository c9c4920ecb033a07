"""The interface of a task: start, target, what the learner sees and does, when an episode ends."""

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Literal, NamedTuple, Protocol

import numpy as np

from harness.arrays import Float, Float32, Mask
from harness.motion import Motion
from harness.robot import Robot

if TYPE_CHECKING:
    from harness.env.episodes import Episodes


class Targets(NamedTuple):
    """Targets drawn ahead."""

    position: Float
    """(count, 3), [m]."""
    relative: Mask
    """Whether the position counts from the end effector at the time the target is set, (count,); else from the
    world's origin."""


class Situation(NamedTuple):
    """Where n arms stand, and what they are asked for. The arrays belong to the environment: they are read only."""

    qpos: Float
    """Joint positions, (n, dof), [rad] or, where a joint slides, [m]."""
    end_effector: Float
    """(n, 3), world frame, [m], as the simulator tells it."""
    target: Float
    """Where the target is now, (n, 3), world frame, [m]."""
    numbers: Float
    """What `Goal.draw` gave with the target, (n, Goal.numbers)."""
    step: Float
    """Environment steps since the target was set, (n,)."""
    within: Float
    """For how many steps in a row the error has been within the task's epsilon, (n,); of no use to `Goal.errors`."""


class Goal(ABC):
    """What a task asks for, where that is more than bringing the end effector to a point that stays.

    The error takes the place of the distance everywhere: rewards are paid by it, the trace records it in the columns of
    distances, and the target is reached where it is at most the task's ``epsilon``.

    Attributes:
        error: What the error is called, in a few words, as ``pose error``.
        unit: Of the error and of ``epsilon``; empty where it has none.
        numbers: How many numbers belong to a target beside its position.
        moves: Whether the target moves, see `displacement`.
        steps_within: The target is reached when the error was within epsilon for so many steps in a row.
        aim: What the arm's own kinematics have to go to: ``position``, that of the target; ``pose``, also its
            orientation, whose x and y axis, in the world frame, are then the first six numbers of `observe`; None where
            they cannot do it.
        observed: What `observe` tells, one line for ``harness describe``.
    """

    error: str
    unit: str = "m"
    numbers: int = 0
    moves: bool = False
    steps_within: int = 1
    aim: Literal["position", "pose"] | None = None
    observed: str = ""

    @abstractmethod
    def errors(self, now: Situation) -> Float:
        """How far each arm is from what it is asked for, (n,), >= 0, a new array; 0 where it does just that."""

    def draw(self, rng: np.random.Generator, position: Float) -> Float:
        """What belongs to targets beside their positions, (count, `numbers`).

        Args:
            rng: The stream that the positions were drawn from.
            position: As `Task.draw_targets` gave them, (count, 3), [m].
        """
        return np.zeros((len(position), 0))

    def displacement(self, numbers: Float, step: Float) -> Float:
        """How far each target has moved so many steps after it was set, (n, 3), [m]; zeros at step 0."""
        return np.zeros((len(step), 3))

    def bounds(self) -> tuple[Float, Float]:
        """The least and the most of each number of `observe`, (size,) both."""
        return np.zeros(0), np.zeros(0)

    def observe(self, now: Situation) -> Float:
        """What the learner sees of the goal beside target, offset and error, (n, size); needs no clipping."""
        return np.zeros((len(now.step), 0))


class Observation(Protocol):
    """Turns the state of the episodes into what the learner sees."""

    @property
    def low(self) -> Float32:
        """Lower bounds, (size,)."""

    @property
    def high(self) -> Float32:
        """Upper bounds, (size,)."""

    def observe(self, episodes: "Episodes") -> Float32:
        """What the learner sees of every episode, (num_envs, size), a new array."""


class Task(Protocol):
    """A frozen dataclass whose fields are the task's parameters. `harness.reach.ReachTask` is one.

    An environment step is one control period. The learner decides every `decision_period` of them; its action is
    repeated in between, and each pays a reward.

    It may also have ``varies``, False for one whose episodes all have the same start and targets, see `varies`; and
    ``goal(robot)``, which returns a `Goal` where the end effector's distance to the target is not all that counts.
    """

    @property
    def robot(self) -> str:
        """Registered name of the arm that the task was made for: the default."""

    @property
    def epsilon(self) -> float:
        """The target is reached within this distance, NOTE eq. 20 [m]; of a task with a `Goal`, within this error."""

    @property
    def ends_at_target(self) -> bool:
        """Whether reaching the target ends the episode; if not, the next target is set."""

    @property
    def horizon(self) -> int:
        """An episode is truncated after so many environment steps."""

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
        """See whether episodes can be drawn for `robot`.

        Raises:
            UsageError: It cannot do the task.
        """

    def draw_start(self, robot: Robot, rng: np.random.Generator) -> Float:
        """Joint positions at the start of an episode, (dof,), within the joint ranges."""

    def draw_targets(self, robot: Robot, rng: np.random.Generator, count: int) -> Targets:
        """Targets of the next `count` episodes.

        Raises:
            UsageError: The arm reaches next to none of them.
        """

    def start_in_words(self, robot: Robot) -> str:
        """Where an episode starts, one line for ``harness describe``."""

    def target_in_words(self, robot: Robot) -> str:
        """What the target is."""

    def target_reward_in_words(self) -> str:
        """What reaching it pays."""


def varies(task: Task) -> bool:
    """Whether episodes differ in start or targets; those of a task that says nothing of it do.

    Where they do not, all deterministic episodes of a policy are alike, and an evaluation does one.
    """
    return bool(getattr(task, "varies", True))


def goal_of(task: Task, robot: Robot) -> Goal | None:
    """What `task` asks of `robot`; None where that is to bring the end effector to a point that stays."""
    goal = getattr(task, "goal", None)
    return None if goal is None else goal(robot)
