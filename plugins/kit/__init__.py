"""The contract kit: checks that plugins have to pass, for the kinds that people write.

In the tests of a plugin::

    from harness_plugins.kit import check_reward

    def test_reward_keeps_the_contract():
        check_reward(MyReward())

If a check fails, it raises `harness.errors.ContractViolation` with the name of the check and what is wrong. Each check
is also a function of its own, so that a test can be parametrised over ``REWARD_CHECKS``. `violations` does not stop at
the first check that fails. `IdealSimulator` is a simulator for tests that need no engine.
"""

from typing import TYPE_CHECKING

from harness.face import face_of

if TYPE_CHECKING:
    from harness.env.ideal import IdealSimulator as IdealSimulator

    from .algorithms import ALGORITHM_CHECKS as ALGORITHM_CHECKS, check_algorithm as check_algorithm
    from .contract import Check as Check, check as check, violations as violations
    from .environments import ENVIRONMENT_CHECKS as ENVIRONMENT_CHECKS, check_environment as check_environment
    from .logs.checks import LOG_CHECKS as LOG_CHECKS, check_log_format as check_log_format
    from .metrics import METRIC_CHECKS as METRIC_CHECKS, check_metric as check_metric
    from .rewards import REWARD_CHECKS as REWARD_CHECKS, check_reward as check_reward
    from .robots import ROBOT_CHECKS as ROBOT_CHECKS, check_robot as check_robot
    from .runs import (
        EXECUTOR_CHECKS as EXECUTOR_CHECKS,
        TRACKER_CHECKS as TRACKER_CHECKS,
        check_executor as check_executor,
        check_tracker as check_tracker,
    )
    from .simulators.checks import SIMULATOR_CHECKS as SIMULATOR_CHECKS, check_simulator as check_simulator
    from .tasks import TASK_CHECKS as TASK_CHECKS, check_task as check_task
else:
    __all__, __getattr__ = face_of(__name__, __file__)
