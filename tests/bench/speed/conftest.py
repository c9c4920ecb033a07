"""Speeds that nobody measured."""

from collections.abc import Callable, Sequence

import pytest

from harness.bench.speed.contest import Round
from harness.bench.speed.entry import Entry, Setting
from harness.bench.speed.speeds import Speed, Speeds


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
