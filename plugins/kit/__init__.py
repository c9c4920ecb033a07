"""The contract kit: checks that plugins have to pass, for the kinds that people write.

In the tests of a plugin::

    from harness_plugins.kit import check_contract

    def test_reward_keeps_the_contract():
        check_contract("reward", MyReward())

If a check fails, it raises `harness.errors.ContractViolation` with the name of the check and what is wrong. Each check
is also a function of its own, so that a test can be parametrised over ``CHECKS["reward"]``. `IdealSimulator` is a
simulator for tests that need no engine.
"""

from typing import TYPE_CHECKING, Any

from harness.face import face_of, lookup

if TYPE_CHECKING:
    from harness.env.ideal import IdealSimulator as IdealSimulator

    from .kits import CHECKS as CHECKS, check_contract as check_contract
else:
    __all__, _look_up = face_of(__name__)

    def __getattr__(name: str) -> Any:
        """A name of today, or of an earlier release."""
        if name.startswith("_") or name in __all__:
            return _look_up(name)
        from .kits import earlier

        return earlier(name) or lookup(__name__, name, 4)
