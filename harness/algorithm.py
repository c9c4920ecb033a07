"""The interface that an algorithm fills: it learns on a vector env and yields a policy."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Literal, Protocol, TypeAlias

from harness.policy import Policy

if TYPE_CHECKING:
    from harness.env import ReachVectorEnv

ActionSpace: TypeAlias = Literal["continuous", "discrete"]
Progress: TypeAlias = Callable[[int], None]
"""Told the number of environment steps done so far."""


class Algorithm(Protocol):
    """A frozen dataclass whose fields are the hyperparameters."""

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
            steps: Environment steps to take, a multiple of `num_envs`.
            seed: Of everything random in the algorithm; the same seed gives the same policy, bit for bit.
            progress: Call it now and then.
        """
