"""The contract kit: checks that plugins have to pass, for every kind of plugin that has a contract.

In the tests of a plugin::

    from harness.testing import check_reward

    def test_reward_keeps_the_contract():
        check_reward(MyReward())

If a check fails, it raises `harness.errors.ContractViolation` with the name of the check and what is wrong. Each check
is also a function of its own, so that a test can be parametrised over ``REWARD_CHECKS``. `violations` does not stop at
the first check that fails. `IdealSimulator` is a simulator for tests that need no engine.
"""

from harness.env.ideal import IdealSimulator
from harness.testing.algorithms.checks import ALGORITHM_CHECKS, check_algorithm
from harness.testing.environments import ENVIRONMENT_CHECKS, check_environment
from harness.testing.executors.checks import EXECUTOR_CHECKS, check_executor
from harness.testing.exports import EXPORT_CHECKS, check_export
from harness.testing.logs.checks import LOG_CHECKS, check_log_format
from harness.testing.metrics.checks import METRIC_CHECKS, check_metric
from harness.testing.rewards.checks import REWARD_CHECKS, check_reward
from harness.testing.robots import ROBOT_CHECKS, check_robot
from harness.testing.simulators.checks import SIMULATOR_CHECKS, check_simulator
from harness.testing.tasks.checks import TASK_CHECKS, check_task
from harness.testing.trackers import TRACKER_CHECKS, check_tracker
from harness.testing.violations import Check, check, violations

__all__ = [
    "ALGORITHM_CHECKS",
    "ENVIRONMENT_CHECKS",
    "EXECUTOR_CHECKS",
    "EXPORT_CHECKS",
    "LOG_CHECKS",
    "METRIC_CHECKS",
    "REWARD_CHECKS",
    "ROBOT_CHECKS",
    "SIMULATOR_CHECKS",
    "TASK_CHECKS",
    "TRACKER_CHECKS",
    "Check",
    "IdealSimulator",
    "check",
    "check_algorithm",
    "check_environment",
    "check_executor",
    "check_export",
    "check_log_format",
    "check_metric",
    "check_reward",
    "check_robot",
    "check_simulator",
    "check_task",
    "check_tracker",
    "violations",
]
