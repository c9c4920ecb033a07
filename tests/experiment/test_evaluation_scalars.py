"""What an evaluation says to trackers."""

import pytest

from harness.experiment.arm_world import evaluation_scalars
from harness.experiment.run_cell import run_cell
from harness.record import EVALUATION, read_trace
from harness.record.trace import mean_return


def test_every_metric_and_the_return_have_a_name(make_cell, toys, tmp_path):
    """Metrics by their names in words, finite; one that is not defined is left out."""
    run_cell(make_cell(), tmp_path / "cell", lambda steps: None)
    trace = read_trace(tmp_path / "cell" / EVALUATION)
    found = evaluation_scalars(trace, toys)
    assert found["Evaluation/Success Rate"] == 0.0
    assert found["Evaluation/Cumulative Reward"] == pytest.approx(mean_return(trace))
    assert "Evaluation/Final Distance" in found
    assert "Evaluation/Steps To Target" not in found  # nobody reached it
