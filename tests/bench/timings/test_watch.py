"""The live page of many cells, which many browsers look at: a look for all of them, by what changed."""

import time
from concurrent.futures import ThreadPoolExecutor
from urllib.request import urlopen

import pytest

from harness.record.status import read_status
from harness_plugins.watch.watch import served
from tests.bench.timings.conftest import cpu_seconds
from tests.bench.timings.test_report import copies

BROWSERS, LOOKS, CELLS = 20, 10, 1000
SPEED = 0.5
"""So much of what asking and answering take is a single reading of the folder, at least."""


@pytest.mark.slow
@pytest.mark.bench
def test_many_browsers(tmp_path, require_ratio):
    """Twenty for ten seconds cost hardly more than to read the status of all cells twice."""
    folder = copies(tmp_path, 300, ["arp"], CELLS // 2, "processes")
    once = min(cpu_seconds(lambda: read_status(folder)) for _ in range(3))
    with served(folder) as address, ThreadPoolExecutor(BROWSERS) as browsers:
        urlopen(f"{address}results").read()  # made once, whoever looks

        def browse(_):
            for _ in range(LOOKS):
                assert b"1,000 of 1,000 trainings done" in urlopen(f"{address}live").read()
                time.sleep(1.0)

        took = cpu_seconds(lambda: list(browsers.map(browse, range(BROWSERS))))
    require_ratio(once / took, SPEED, f"({took:.2f} s for all answers, one reading {once:.2f} s)")
