"""What evaluations of one cell have in common: world, episodes, and what the arm's own kinematics do there."""

from collections.abc import Callable
from functools import cached_property
from pathlib import Path

from harness.env.make import World
from harness.experiment.evaluation.evaluate import EVALUATION_SEED, Act, act_of, evaluate, random_actions
from harness.experiment.evaluation.ik_steps import ik_steps
from harness.policy import Policy
from harness.task import varies


class Evaluator:
    """Records what policies do in a world."""

    def __init__(self, world: World, episodes: int, on_step: Callable[[], None] = lambda: None) -> None:
        """Open nothing yet.

        Args:
            world: Where.
            episodes: How many an evaluation has. Where start and targets are always the same, the episodes of a
                deterministic policy are alike, and it does one.
            on_step: Called after every step of an evaluation.
        """
        self._world, self._episodes, self._on_step = world, episodes, on_step

    def record(self, policy: Policy, deterministic: bool, path: Path) -> None:
        """Write the trace of an evaluation in which `policy` takes the one action of each observation, or draws."""
        episodes = self._episodes if varies(self._world.task) or not deterministic else 1
        self._evaluate(act_of(policy, deterministic), episodes, path)

    def record_random(self, policy: Policy, path: Path) -> None:
        """Write the trace of random actions, for a floor of `policy`."""
        self._evaluate(random_actions(policy.floor()), self._episodes, path)

    def _evaluate(self, act: Act, episodes: int, path: Path) -> None:
        evaluate(self._world, act, episodes, path, ik_steps=self._ik_steps, on_step=self._on_step)

    @cached_property
    def _ik_steps(self) -> tuple[int | None, ...] | None:
        return ik_steps(self._world, self._episodes, EVALUATION_SEED)
