"""The interface that an algorithm fills: it learns on a vector env and yields a policy."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Protocol, TypeAlias

from harness.arrays import Float, Float32, Mask
from harness.face import face_of
from harness.policy import Policy
from harness.record.progress import (
    Progress as Progress,
    Ring as Ring,
    TrainingState as TrainingState,
    as_state as as_state,
    under as under,
)

if TYPE_CHECKING:
    from gymnasium import Space

    from harness.authoring.act_without_learning import act_for as act_for
    from harness.authoring.generator_state import (
        pack_generator as pack_generator,
        restore_generator as restore_generator,
    )
    from harness.robot import Robot
    from harness.task import Task
else:
    __all__, __getattr__ = face_of(__name__, "ActionSpace", "Algorithm", "Goals", "TrainingEnv")

ActionSpace: TypeAlias = Literal["continuous", "discrete"]

IN_ENVIRONMENTS = "in_environments"
"""The class variable in which an algorithm may declare other defaults for a `harness.environment.Environment`.

It is a mapping from parameters to values, such as ``{"gamma": 0.99}``. Where a user chose nothing, such a value is
written into the cell as if the user had chosen it: the algorithm is then called ``ppo:gamma=0.99``. A value that a
preset of the algorithm brings stays. On an arm, the defaults of the fields hold.
"""


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


class TrainingEnv(Protocol):
    """The vector env that an algorithm trains on: many arms of a task, or many copies of somebody's environment.

    It has the members of a `gymnasium.vector.VectorEnv` that are named here, and begins the next episode of an env in
    the step that ends one (`gymnasium.vector.AutoresetMode.SAME_STEP`). The arm's env is that of
    `harness.make_env`.
    """

    @property
    def num_envs(self) -> int:
        """How many envs it has."""

    @property
    def environment_steps(self) -> int:
        """Steps taken so far, counted over all envs."""

    @property
    def observation_space(self) -> "Space[Any]":
        """The space of all envs together: a box of shape (num_envs, observation_size), float32."""

    @property
    def single_observation_space(self) -> "Space[Any]":
        """The space of one env: a box of shape (observation_size,), float32."""

    @property
    def action_space(self) -> "Space[Any]":
        """The space of all envs together."""

    @property
    def single_action_space(self) -> "Space[Any]":
        """The space of one env: a box, or a `gymnasium.spaces.Discrete`."""

    def reset(self, *, seed: int | None = None) -> tuple[Float32, dict[str, Any]]:
        """Begin an episode in every env; returns the observations, (num_envs, observation_size), and infos."""

    def step(self, actions: Any) -> tuple[Float32, Float, Mask, Mask, dict[str, Any]]:
        """A decision in every env.

        Args:
            actions: As `action_space` has them, (num_envs, action_size), or (num_envs,) where they are discrete.

        Returns:
            Observations, (num_envs, observation_size); what was paid, terminations and truncations, (num_envs,) each;
            infos. These hold ``is_success``, (num_envs,), and where an episode ended ``final_obs``, its last
            observation, with ``_final_obs``, the envs that have one.
        """


class Algorithm(Protocol):
    """A frozen dataclass whose fields are the hyperparameters.

    These members may be there too:

    * ``learns``: False if the algorithm only acts, see `learns`.
    * ``needs_arm``: True if it computes with the arm of the task. It then cannot train in other people's Gymnasium
      environments, see `needs_arm`.
    * ``needs_goals``: True if it pays recorded steps again for other goals, see `needs_goals`.
    * ``in_environments``: defaults for other people's Gymnasium environments, see `IN_ENVIRONMENTS`.
    * ``why_not(task, robot)``: says why it cannot do a task although it takes the task's actions, see `why_not`.
    * ``sources``: the modules that it works in, see `harness.registry.sources.source_files`.
    """

    @property
    def action_spaces(self) -> frozenset[ActionSpace]:
        """The kinds of action that it can choose."""

    @property
    def num_envs(self) -> int:
        """How many envs it trains on at once."""

    def train(self, env: TrainingEnv, steps: int, seed: int, progress: Progress) -> Policy:
        """Learn for `steps` environment steps, counted over all envs, and yield the policy.

        Args:
            env: It is seeded already: reset it without a seed.
            steps: Environment steps to take, a multiple of `num_envs`. Go on deciding until `env.environment_steps` has
                grown by this number. The last decision is not cut short.
            seed: The seed of everything random in the algorithm. The same seed gives the same policy, bit for bit.
            progress: Call it now and then, and at the end; see `harness.algorithm.Progress` for more.
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
