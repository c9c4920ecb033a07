"""What a worker is told to do."""

import json
from pathlib import Path

from harness.executor import CellOptions
from harness.experiment.installation import Describe
from harness.experiment.run_cell import TrainCell
from harness.experiment.workers.order import Order, read_order
from harness.registry import Choice
from harness.registry.given import PluginClass, PluginFile
from harness_plugins.transfer.jobs import EvaluateElsewhere

PLUGINS = (PluginFile("/a/mine.py", "x = 'ü'\n"), PluginClass("rewards", "mine:Mine"))
WORKS = {
    "train": lambda cell: TrainCell(cell, CellOptions(checkpoint_every=100, tracked=True)),
    "evaluate elsewhere": lambda cell: EvaluateElsewhere(Path("/a/cell"), Choice("mujoco", (("substeps", 4),), "m")),
    "train by a file": lambda cell: TrainCell(cell, CellOptions(plugins=PLUGINS)),
    "evaluate by a file": lambda cell: EvaluateElsewhere(Path("/a/cell"), Choice("mujoco"), PLUGINS),
    "describe": lambda cell: Describe((cell,), PLUGINS),
}


def test_order_is_read_as_it_was_given(make_cell, tmp_path_factory, subtests):
    """Of every kind of work: its class and all that it holds come back from one line of text."""
    for case, work in WORKS.items():
        with subtests.test(case):
            order = Order(tmp_path_factory.mktemp("case") / "cell", work(make_cell()))
            line = order.line()
            assert "\n" not in line
            assert read_order(line)[0] == order


def test_order_names_who_does_it(make_cell):
    """Nobody has to guess from what stands in it."""
    told = json.loads(Order(Path("cell"), TrainCell(make_cell())).line())
    assert told["work"] == "harness.experiment.run_cell:TrainCell"


def test_order_says_what_the_user_typed(make_cell, monkeypatch):
    """The manifest will record it."""
    monkeypatch.setattr("sys.argv", ["harness", "run"])
    assert read_order(Order(Path("cell"), TrainCell(make_cell())).line())[1] == ["harness", "run"]
