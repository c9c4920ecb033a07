"""The interface that an algorithm fills: it learns on a vector env and yields a policy."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, Protocol, TypeAlias

from harness.arrays import Float
from harness.policy import Policy
from harness.progress import Progress

if TYPE_CHECKING:
    from harness.env import ReachVectorEnv
    from harness.robot import Robot
    from harness.task import Task

ActionSpace: TypeAlias = Literal["continuous", "discrete"]


@dataclass(frozen=True, eq=False)
class Goals:
    """What an env tells of its goals, as ``env.goals``, to an algorithm that learns in hindsight.

    Attributes:
        achieved: Columns of an observation: the goal that was achieved.
        desired: Columns of an observation: the goal that was to be achieved, as many as of `achieved`.
        pay: What the reward that the training is paid by pays, (n,), for steps after which `achieved` was achieved and
            `desired` was to be; both (n, goal_size).
    """

    achieved: slice
    desired: slice
    pay: Callable[[Float, Float], Float]


class Algorithm(Protocol):
    """A frozen dataclass whose fields are the hyperparameters.

    It may also have what ``harness bench`` times it beside:

    * ``bare_training(env, steps, seed)``: the library without the harness. It returns a function without arguments that
      trains a new model with the same settings for `steps` steps of `env`, a `gymnasium.Env` of one robot.
    * ``peer_trainings()``: trainings by other people's libraries, by name, each a function like ``bare_training`` that
      raises `UsageError` where its library is not installed.

    It may also have ``learns``, False for one that only acts (see `learns`), ``needs_arm``, True for one that computes
    with the arm of the task and so cannot train in an environment of anybody (see `needs_arm`), ``needs_goals``, True
    for one that pays recorded steps again for other goals (see `needs_goals`),
    ``why_not(task, robot)``, for one that cannot do every task whose actions it takes (see `why_not`), and ``sources``,
    like any plugin that works in modules of its own (see `harness.registry.sources.source_files`).
    """

    @property
    def action_spaces(self) -> frozenset[ActionSpace]:
        """The kinds of action that it can choose."""

    @property
    def num_envs(self) -> int:
        """How many envs it trains on at once."""

    def train(self, env: "ReachVectorEnv", steps: int, seed: int, progress: Progress) -> Policy:
        """Learn for `steps` environment steps, counted over all envs, and yield the policy.

        Args:
            env: Already seeded by whoever made it: reset it without a seed. It starts new episodes by itself
                (`gymnasium.vector.AutoresetMode.SAME_STEP`).
            steps: Environment steps to take, a multiple of `num_envs`: decide while `env.environment_steps` has grown
                by less. A decision is not cut short.
            seed: Of everything random in the algorithm; the same seed gives the same policy, bit for bit.
            progress: Call it now and then, and at the end; see `harness.progress.Progress` for more.
        """


def learns(algorithm: Algorithm) -> bool:
    """Whether training changes the policy; an algorithm that says nothing of it learns."""
    return bool(getattr(algorithm, "learns", True))


def needs_arm(algorithm: Algorithm) -> bool:
    """Whether it computes with ``env.task`` and ``env.robot``, which a `harness.environment.Environment` has not."""
    return bool(getattr(algorithm, "needs_arm", False))


def needs_goals(algorithm: Algorithm) -> bool:
    """Whether it computes with ``env.goals``, see `Goals`, which an env has whose reward is a function of goals."""
    return bool(getattr(algorithm, "needs_goals", False))


def why_not(algorithm: Algorithm, task: "Task", robot: "Robot") -> str:
    """Why an algorithm cannot do a task whose actions it takes; empty if it can, and if it says nothing of it."""
    ask = getattr(algorithm, "why_not", None)
    return str(ask(task, robot)) if ask else ""
