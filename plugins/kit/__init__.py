"""The contract kit: checks that plugins have to pass, for every kind of plugin that has a contract.

In the tests of a plugin::

    from harness_plugins.kit import check_reward

    def test_reward_keeps_the_contract():
        check_reward(MyReward())

If a check fails, it raises `harness.errors.ContractViolation` with the name of the check and what is wrong. Each check
is also a function of its own, so that a test can be parametrised over ``REWARD_CHECKS``. `violations` does not stop at
the first check that fails. `IdealSimulator` is a simulator for tests that need no engine.
"""

from typing import TYPE_CHECKING

from harness.authoring.face import lazy_names

if TYPE_CHECKING:
    from harness.authoring.checking import IdealSimulator as IdealSimulator

    from .algorithms import ALGORITHM_CHECKS as ALGORITHM_CHECKS, check_algorithm as check_algorithm
    from .contract import Check as Check, check as check, violations as violations
    from .descriptions import (
        DESCRIPTION_CHECKS as DESCRIPTION_CHECKS,
        check_description_format as check_description_format,
    )
    from .environments import ENVIRONMENT_CHECKS as ENVIRONMENT_CHECKS, check_environment as check_environment
    from .executors import EXECUTOR_CHECKS as EXECUTOR_CHECKS, check_executor as check_executor
    from .exports import EXPORT_CHECKS as EXPORT_CHECKS, check_export as check_export
    from .logs.checks import LOG_CHECKS as LOG_CHECKS, check_log_format as check_log_format
    from .metrics import METRIC_CHECKS as METRIC_CHECKS, check_metric as check_metric
    from .rewards import REWARD_CHECKS as REWARD_CHECKS, check_reward as check_reward
    from .robots import ROBOT_CHECKS as ROBOT_CHECKS, check_robot as check_robot
    from .screens import SCREEN_CHECKS as SCREEN_CHECKS, check_screen as check_screen
    from .sections import SECTION_CHECKS as SECTION_CHECKS, check_section as check_section
    from .simulators.checks import SIMULATOR_CHECKS as SIMULATOR_CHECKS, check_simulator as check_simulator
    from .tasks import TASK_CHECKS as TASK_CHECKS, check_task as check_task
    from .trackers import TRACKER_CHECKS as TRACKER_CHECKS, check_tracker as check_tracker

_NAMES = {
    "harness_plugins.kit.algorithms": ("ALGORITHM_CHECKS", "check_algorithm"),
    "harness_plugins.kit.contract": ("Check", "check", "violations"),
    "harness_plugins.kit.descriptions": ("DESCRIPTION_CHECKS", "check_description_format"),
    "harness_plugins.kit.environments": ("ENVIRONMENT_CHECKS", "check_environment"),
    "harness_plugins.kit.executors": ("EXECUTOR_CHECKS", "check_executor"),
    "harness_plugins.kit.exports": ("EXPORT_CHECKS", "check_export"),
    "harness.authoring.checking": ("IdealSimulator",),
    "harness_plugins.kit.logs.checks": ("LOG_CHECKS", "check_log_format"),
    "harness_plugins.kit.metrics": ("METRIC_CHECKS", "check_metric"),
    "harness_plugins.kit.rewards": ("REWARD_CHECKS", "check_reward"),
    "harness_plugins.kit.robots": ("ROBOT_CHECKS", "check_robot"),
    "harness_plugins.kit.screens": ("SCREEN_CHECKS", "check_screen"),
    "harness_plugins.kit.sections": ("SECTION_CHECKS", "check_section"),
    "harness_plugins.kit.simulators.checks": ("SIMULATOR_CHECKS", "check_simulator"),
    "harness_plugins.kit.tasks": ("TASK_CHECKS", "check_task"),
    "harness_plugins.kit.trackers": ("TRACKER_CHECKS", "check_tracker"),
}
"""The public names of each module; looked up when they are first used, so that pytest and a command start quickly."""

__all__ = sorted(name for names in _NAMES.values() for name in names)  # noqa: PLE0605

__getattr__ = lazy_names(__name__, {name: home for home, names in _NAMES.items() for name in names}, {})
