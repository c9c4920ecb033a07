"""What it costs to know where the time of a cell goes."""

from collections.abc import Callable

import pytest

from harness.experiment.run_cell import run_cell
from harness.experiment.watch import UNWATCHED, Watch
from harness.record.cell import Cell
from harness.registry.choice import Choice
from harness_plugins.bench.stopwatch import CLOCK, Stopwatch

pytestmark = pytest.mark.bench
MakeCell = Callable[..., Cell]


def test_a_timed_cell_beside_an_untimed_one(tmp_path, require_speed, amount, make_cell: MakeCell):
    """Where every step is cheap and nothing is learned, a timed cell is nearly as fast: 0.97 was measured."""
    named = {key: Choice(name, (), name) for key, name in (("simulator", "kinematic"), ("algorithm", "random"))}
    task, steps = Choice("fd100-reach", (), "fd100-reach"), amount(4_000, 40)
    cell = make_cell(task=task, steps=steps, evaluation_episodes=1, **named)

    def run(watch: Watch) -> None:
        assert run_cell(cell, tmp_path / "cell", lambda steps: None, watch=watch).reason == ""

    require_speed(lambda: run(UNWATCHED), lambda: run(Stopwatch(CLOCK())), at_least=0.85)
