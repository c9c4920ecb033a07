"""What it costs to know where the time of a cell goes."""

from collections.abc import Callable

import pytest

from harness.bench.meter import CLOCK
from harness.bench.stopwatch import Stopwatch
from harness.experiment.run_cell import run_cell
from harness.experiment.watch import UNWATCHED, Watch
from harness.record.cell import Cell
from harness.registry.choice import Choice

pytestmark = pytest.mark.bench
MakeCell = Callable[..., Cell]


def test_a_timed_cell_has_nineteen_twentieths_of_an_untimed_one(tmp_path, speed_ratio, make_cell: MakeCell):
    """Where every step is cheap and nothing is learned, a timed cell does at least 0.95 of the steps of another."""
    named = {key: Choice(name, (), name) for key, name in (("simulator", "kinematic"), ("algorithm", "random"))}
    cell = make_cell(task=Choice("fd100-reach", (), "fd100-reach"), steps=4_000, evaluation_episodes=1, **named)

    def run(watch: Watch) -> None:
        assert run_cell(cell, tmp_path / "cell", lambda steps: None, watch=watch).reason == ""

    assert speed_ratio(lambda: run(UNWATCHED), lambda: run(Stopwatch(CLOCK()))) >= 0.95
