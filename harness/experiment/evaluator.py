"""What evaluations of one cell have in common: world, episodes, and what the arm's own kinematics do there."""

from functools import cached_property
from pathlib import Path

from harness.env.make import World
from harness.experiment.evaluate import EVALUATION_SEED, act_of, evaluate, random_actions
from harness.experiment.ik_steps import ik_steps
from harness.policy import Policy
from harness.task import varies


class Evaluator:
    """Records what policies do in a world."""

    def __init__(self, world: World, episodes: int) -> None:
        """Open nothing yet.

        Args:
            world: Where.
            episodes: How many an evaluation has. Where start and targets are always the same, the episodes of a
                deterministic policy are alike, and it does one.
        """
        self._world, self._episodes = world, episodes

    def record(self, policy: Policy, deterministic: bool, path: Path) -> None:
        """Write the trace of an evaluation in which `policy` takes the one action of each observation, or draws."""
        episodes = self._episodes if varies(self._world.task) or not deterministic else 1
        evaluate(self._world, act_of(policy, deterministic), episodes, path, ik_steps=self._ik_steps)

    def record_random(self, policy: Policy, path: Path) -> None:
        """Write the trace of random actions, for a floor of `policy`."""
        evaluate(self._world, random_actions(policy.floor()), self._episodes, path, ik_steps=self._ik_steps)

    @cached_property
    def _ik_steps(self) -> tuple[int | None, ...] | None:
        return ik_steps(self._world, self._episodes, EVALUATION_SEED)
