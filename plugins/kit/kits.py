"""All checks, by the kind of what they check."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from .algorithms import ALGORITHM_CHECKS, ALGORITHM_WARNINGS
from .contract import Check
from .environments import ENVIRONMENT_CHECKS
from .executors import EXECUTOR_CHECKS
from .exports import EXPORT_CHECKS
from .logs.checks import LOG_CHECKS
from .metrics import METRIC_CHECKS
from .rewards import REWARD_CHECKS, REWARD_WARNINGS
from .robots import ROBOT_CHECKS, ROBOT_WARNINGS, SIMULATED_ROBOT_CHECKS
from .simulators.calls import a_long_simulation_neither_drifts_nor_leaks
from .simulators.checks import SIMULATOR_CHECKS, SIMULATOR_WARNINGS
from .speed import (
    a_metric_is_quick,
    a_reward_is_quick,
    a_simulation_is_quick,
    a_training_is_quick,
    an_episode_is_drawn_quickly,
)
from .tasks import TASK_CHECKS, TASK_WARNINGS
from .trackers import TRACKER_CHECKS

LONG_SECONDS = 900.0
"""How long ``harness check`` waits for a check that takes minutes."""


@dataclass(frozen=True)
class Kit:
    """The checks of one kind.

    Attributes:
        contract: What has to hold.
        advice: Warnings: what is slow, or was not tried.
        long: What takes minutes, and is run on demand.
        seconds: How long ``harness check`` waits for a check that is not `long`: many times what a sound plugin takes.
    """

    contract: tuple[Check, ...]
    advice: tuple[Check, ...] = ()
    long: tuple[Check, ...] = ()
    seconds: float = 60.0

    @property
    def checks(self) -> tuple[Check, ...]:
        """All of them."""
        return (*self.contract, *self.advice, *self.long)

    def seconds_of(self, check: Check) -> float:
        """How long ``harness check`` waits for one of its checks."""
        return LONG_SECONDS if check in self.long else self.seconds


KITS: Mapping[str, Kit] = MappingProxyType(
    {
        "simulators": Kit(
            SIMULATOR_CHECKS,
            (*SIMULATOR_WARNINGS, a_simulation_is_quick),
            (a_long_simulation_neither_drifts_nor_leaks,),
        ),
        "algorithms": Kit(ALGORITHM_CHECKS, (*ALGORITHM_WARNINGS, a_training_is_quick), seconds=300.0),
        "rewards": Kit(REWARD_CHECKS, (*REWARD_WARNINGS, a_reward_is_quick), seconds=15.0),
        "metrics": Kit(METRIC_CHECKS, (a_metric_is_quick,), seconds=15.0),
        "tasks": Kit(TASK_CHECKS, (*TASK_WARNINGS, an_episode_is_drawn_quickly)),
        "robots": Kit((*ROBOT_CHECKS, *SIMULATED_ROBOT_CHECKS), ROBOT_WARNINGS, seconds=120.0),
        "environments": Kit(ENVIRONMENT_CHECKS),
        "executors": Kit(EXECUTOR_CHECKS, seconds=120.0),
        "trackers": Kit(TRACKER_CHECKS),
        "logs": Kit(LOG_CHECKS),
    }
)
"""By kind, as `harness.hookspecs.KINDS` has them; commands and sections have none."""
EXPORTS = Kit(EXPORT_CHECKS)
"""The kit of policies; see `harness_plugins.kit.exports`."""
