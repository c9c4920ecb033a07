"""Memory is that of the process that is measured."""

import sys

from tests.bench.timings.processes import measure


def test_what_the_measuring_process_holds_does_not_count():
    """Three hundred megabytes here, and a command that does nothing."""
    held = bytearray(b"1") * 300_000_000
    taken = measure(sys.executable, "-c", "pass")
    assert len(held) == 300_000_000
    assert taken.megabytes < 100.0


def test_what_the_command_holds_counts():
    """A hundred megabytes there."""
    taken = measure(sys.executable, "-c", "held = bytearray(b'1') * 100_000_000; print(len(held))")
    assert taken.out == "100000000\n"
    assert taken.megabytes > 100.0


def test_only_its_own_time_counts():
    """Work that was done before is no time of the command."""
    sum(range(20_000_000))
    assert (
        measure(sys.executable, "-c", "pass").cpu_seconds
        < measure(sys.executable, "-c", "sum(range(20_000_000))").cpu_seconds
    )
