"""Failures: one line, whatever was raised; a user who interrupts is heard."""

import pytest

from harness.errors import SimulationDiverged
from harness_plugins.parity.performance import Failure, attempt, part


def raising(error):
    """Work that ends so."""

    def work():
        raise error

    return work


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (SimulationDiverged("qpos is not finite"), "qpos is not finite"),
        (RuntimeError("the belt\n  slipped"), "RuntimeError: the belt slipped"),
        (MemoryError(), "MemoryError"),
    ],
)
def test_the_reason_is_one_line(error, reason):
    """This project's own errors speak for themselves; strangers' are named."""
    assert attempt(raising(error)) == Failure(reason)


def test_a_result_is_passed_on():
    """Nothing raised, nothing lost."""
    assert attempt(lambda: 3) == 3


def test_an_interrupt_is_no_failure_of_a_simulator():
    """It ends the command."""
    with pytest.raises(KeyboardInterrupt):
        attempt(raising(KeyboardInterrupt()))


def test_results_and_failures_are_parted():
    """Both in their order."""
    assert part({"a": 1, "b": Failure("x"), "c": 2}) == ({"a": 1, "c": 2}, {"b": Failure("x")})
