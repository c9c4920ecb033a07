"""Timings side by side: what is compared takes turns in one run, and medians are quoted."""

import statistics
import time
from collections.abc import Callable

import pytest


@pytest.fixture
def speed_ratio(benchmark):
    """Speed of `candidate` relative to `reference`; both take no argument and do equal work.

    They take turns, so that a slow moment of the machine meets both. The ratio and both medians go into the
    benchmark's extra info and onto the terminal.
    """

    def measure(reference: Callable[[], object], candidate: Callable[[], object], rounds: int = 9) -> float:
        reference()
        candidate()
        pairs = [(_seconds(reference), _seconds(candidate)) for _ in range(rounds)]
        ratio = statistics.median(first / second for first, second in pairs)
        medians = [statistics.median(column) for column in zip(*pairs, strict=True)]
        benchmark.extra_info.update(ratio=ratio, reference_s=medians[0], candidate_s=medians[1])
        benchmark.pedantic(candidate, rounds=1)
        print(f"\n  speed ratio {ratio:.3f} (reference {medians[0]:.4f} s, candidate {medians[1]:.4f} s)")  # noqa: T201
        return ratio

    return measure


def _seconds(function: Callable[[], object]) -> float:
    start = time.perf_counter()
    function()
    return time.perf_counter() - start
