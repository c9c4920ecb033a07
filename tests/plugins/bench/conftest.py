"""Times of a cell that add up to a round number, and speeds that nobody measured."""

from collections.abc import Callable, Sequence
from typing import Any

import pytest

from harness.record.cell import Cell
from harness_plugins.bench.cells import Timing
from harness_plugins.bench.contests import Entry, Round, Setting
from harness_plugins.bench.speeds import Speed, Speeds
from harness_plugins.bench.stopwatch import PARTS, CellTimes

SECONDS = dict(zip(PARTS, (1.0, 2.0, 0.5, 0.25, 0.75, 4.5, 0.6, 0.4), strict=True))


@pytest.fixture
def make_times() -> Callable[..., CellTimes]:
    """10 seconds for 1,000 steps; some parts may be said otherwise."""

    def make(**seconds: float) -> CellTimes:
        return CellTimes({**SECONDS, **seconds}, steps=1_000, calls=4_000, core_share=0.95)

    return make


@pytest.fixture
def make_timing(make_cell: Callable[..., Cell], make_times: Callable[..., CellTimes]) -> Callable[..., Timing]:
    """A combination with rounds of which some parts are said otherwise; by default one as it is."""

    def make(*rounds: dict[str, float], clock_seconds: float = 5e-7, **fields: Any) -> Timing:
        return Timing(make_cell(**fields), tuple(make_times(**said) for said in rounds or ({},)), clock_seconds)

    return make


@pytest.fixture
def make_speeds() -> Callable[..., Speeds]:
    """One simulator per row of speeds, one number per round; some fields may be said otherwise."""

    def make(*rows: Sequence[float], **fields: object) -> Speeds:
        speeds = tuple(
            Speed(
                Entry("simulators", "simulators", f"sim-{number}"),
                tuple(Round({"bare engine": 1e-4, "env": 1e-4 / speed}, {"env": speed}) for speed in row),
            )
            for number, row in enumerate(rows)
        )
        given = {
            "rounds": len(rows[0]) if rows else 1,
            "setting": Setting(),
            "speeds": speeds,
            "failed": (),
            "left_out": (),
            "cpu": "a cpu",
            "versions": {"numpy": "2.0"},
        }
        return Speeds(**{**given, **fields})

    return make
