"""Logs that programs of others wrote, as they left them; `written/README.md` says which."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from harness.errors import SchemaError
from harness.log import open_logs
from harness.log.open_log import find_logs
from tests.registered import REGISTRY

WRITTEN = Path(__file__).parent / "written"
RISING = [-10.0, -9.0, -8.0, -7.0, -6.0]
STEPS = [1000.0, 2000.0, 3000.0, 4000.0, 5000.0]
SHARES = [0.0, 0.2, 0.4, 0.6, 0.8]
OF_RLLIB = {
    "time": [400, 800, 1200],
    "reward/recorded": [22.111, 22.0, 20.447],
    "length": [22.111, 22.056, 20.486],
    "since": [0, 0, 0],
}


@pytest.mark.parametrize(
    ("name", "seed", "columns"),
    [
        ("rllib/result.json", 3, OF_RLLIB),
        ("rllib-table/progress.csv", 3, OF_RLLIB),
        (
            "mlflow", 1,
            {"time": STEPS, "reward/recorded": [it + 1 for it in RISING], "behaviour/success": SHARES,
             "length": [20] * 5, "since": [0, 0, 1000, 2000, 3000]},
        ),
        (
            "torchrl", None,
            {"iteration": STEPS, "reward/recorded": RISING, "behaviour/success": SHARES, "since": [np.nan] * 5},
        ),
        (
            "skrl", None,
            {"iteration": [50, 100, 150, 200], "reward/recorded": [-10, -7.5, -5, -2.5], "length": [10] * 4,
             "since": [0, 50, 100, 150]},
        ),
        ("d3rlpy", 1, {"iteration": STEPS, "reward/recorded": RISING, "since": STEPS}),
        (
            "tianshou", None,
            {"time": STEPS, "reward/recorded": RISING, "length": [20] * 5, "since": [0, *STEPS[:-1]]},
        ),
    ],
)  # fmt: skip
def test_what_a_program_wrote_is_read(name, seed, columns):
    """Through the door that all logs come in by, and nothing in it is read a second time."""
    [log] = find_logs(WRITTEN / name, REGISTRY).logs
    assert log.facts.seed == seed
    assert log.facts.env == "CartPole-v1" * name.startswith("rllib")
    assert {*log.columns} == {*columns}
    for column, values in columns.items():
        np.testing.assert_allclose(log[column], values, atol=1e-3)


def test_a_run_of_mlflow_has_the_name_that_it_was_given():
    """Its folder is called by a hash."""
    [log] = open_logs(WRITTEN / "mlflow", REGISTRY)
    assert log.facts.run == "base_1"


def test_a_file_of_a_curve_that_is_damaged_is_refused_by_its_line(tmp_path):
    """Never read in part; a last row that does not end is left out."""
    copy = tmp_path / "run"
    shutil.copytree(WRITTEN / "torchrl", copy)
    file = copy / "scalars/train/success_rate.csv"
    file.write_text("1000,0.5\n2000,x\n3000,0.5\n")
    with pytest.raises(SchemaError, match=r"success_rate\.csv, line 2: column .* holds x"):
        open_logs(copy, REGISTRY)
    file.write_text("1000,0.5\n2000,0.25\n3000,0.")
    [log] = open_logs(copy, REGISTRY)
    assert log["iteration"].tolist() == [1000, 2000]
