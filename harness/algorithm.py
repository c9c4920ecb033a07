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
    """The goals of an env, ``env.goals``, for an algorithm that learns in hindsight: as if it had wanted what it got.

    Attributes:
        achieved: The columns of an observation that hold the goal that was achieved.
        desired: The columns of an observation that hold the goal to achieve; as many columns as `achieved` has.
        pay: A function of achieved goals and desired goals, both (n, goal_size). It returns what the training's reward
            pays for steps that end with these goals, (n,).
    """

    achieved: slice
    desired: slice
    pay: Callable[[Float, Float], Float]


class Algorithm(Protocol):
    """A frozen dataclass whose fields are the hyperparameters.

    It may also have two methods for ``harness bench``, which compares the algorithm's speed with what they return:

    * ``bare_training(env, steps, seed)``: the library without the harness. It returns a function without arguments that
      trains a new model with the same settings for `steps` steps of `env`, a `gymnasium.Env` of one robot.
    * ``peer_trainings()``: trainings with other people's libraries, by name. Each is a function like ``bare_training``,
      and raises `UsageError` if its library is not installed.

    These members may be there too:

    * ``learns``: False if the algorithm only acts, see `learns`.
    * ``needs_arm``: True if it computes with the arm of the task. It then cannot train in other people's Gymnasium
      environments, see `needs_arm`.
    * ``needs_goals``: True if it pays recorded steps again for other goals, see `needs_goals`.
    * ``why_not(task, robot)``: says why it cannot do a task although it takes the task's actions, see `why_not`.
    * ``sources``: the modules that it works in, see `harness.registry.sources.source_files`.
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
            env: It is seeded already: reset it without a seed. It starts new episodes by itself
                (`gymnasium.vector.AutoresetMode.SAME_STEP`).
            steps: Environment steps to take, a multiple of `num_envs`. Go on deciding until `env.environment_steps` has
                grown by this number. The last decision is not cut short.
            seed: The seed of everything random in the algorithm. The same seed gives the same policy, bit for bit.
            progress: Call it now and then, and at the end; see `harness.progress.Progress` for more.
        """


def learns(algorithm: Algorithm) -> bool:
    """Whether training changes the policy. It does if the algorithm has no ``learns``."""
    return bool(getattr(algorithm, "learns", True))


def needs_arm(algorithm: Algorithm) -> bool:
    """Whether it uses ``env.task`` and ``env.robot``, which the env of a `harness.environment.Environment` lacks."""
    return bool(getattr(algorithm, "needs_arm", False))


def needs_goals(algorithm: Algorithm) -> bool:
    """Whether it uses ``env.goals``, see `Goals`. Only an env whose reward is a function of goals has them."""
    return bool(getattr(algorithm, "needs_goals", False))


def why_not(algorithm: Algorithm, task: "Task", robot: "Robot") -> str:
    """Why an algorithm cannot do a task whose actions it takes. Empty if it can, or if it has no ``why_not``."""
    ask = getattr(algorithm, "why_not", None)
    return str(ask(task, robot)) if ask else ""
