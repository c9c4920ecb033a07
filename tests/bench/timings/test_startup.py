"""How long a user waits for a command that computes nothing."""

import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytestmark = pytest.mark.bench
LIMIT = 0.25


def _harness() -> str:
    path = shutil.which("harness", path=str(Path(sys.executable).parent))
    assert path is not None
    return path


@pytest.mark.parametrize("argument", ["--help", "list"])
def test_light_commands_answer_within_a_quarter_of_a_second(benchmark, argument):
    """`harness --help` and `harness list` take less than 0.25 s, in the median of 15 calls."""
    command, times = [_harness(), argument], []

    def call() -> None:
        start = time.perf_counter()
        subprocess.run(command, check=True, capture_output=True)
        times.append(time.perf_counter() - start)

    benchmark.pedantic(call, rounds=15, warmup_rounds=2)
    median = statistics.median(times[2:])
    print(f"\n  harness {argument}: {median:.3f} s")  # noqa: T201
    assert median < LIMIT
