"""The interface of a task: start, target, what the learner sees and does, when an episode ends."""

from typing import TYPE_CHECKING, NamedTuple, Protocol

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

    It may also have ``varies``, False for one whose episodes all have the same start and targets, see `varies`.
    """

    @property
    def robot(self) -> str:
        """Registered name of the arm that the task was made for: the default."""

    @property
    def epsilon(self) -> float:
        """The target is reached within this distance, NOTE eq. 20 [m]."""

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
