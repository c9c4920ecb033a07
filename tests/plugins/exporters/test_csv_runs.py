"""Traces as CSV files in the experimenters' columns."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from harness.record.folder import TRACE
from harness.record.trace import read_trace
from harness.registry.choice import Choice, choose
from harness.score.csv_steps import EVENTS, PAY, STEPS
from harness.score.open_steps import open_steps
from harness.score.rescore import rescore
from harness_plugins.exporters.csv_runs import COLUMNS, write_csv

THEIRS = "t,beginDistance,prevBest,distance,delta_distance,reward,target x,target y,target z,endEff x,endEff y,endEff z"


@pytest.fixture
def trace(make_cell, make_plan, run_here, tmp_path):
    """Of a training in three envs at once, several episodes of each."""
    cell = make_cell(steps=60, algorithm=Choice("wander", (("num_envs", 3),), "wander:num_envs=3"))
    results = run_here(make_plan(cell), tmp_path / "out")
    assert not results.failed
    return results.store.cell_folder(cell) / TRACE


@pytest.fixture
def written(trace, tmp_path):
    """The file."""
    write_csv(trace, tmp_path / "run.csv")
    return tmp_path / "run.csv"


def _columns(path):
    table = np.genfromtxt(path, delimiter=",", skip_header=1)
    return dict(zip(path.read_text().split("\n")[0].split(","), table.T, strict=True))


def test_the_experimenters_columns_come_first(written):
    """By their names, in their order, nothing in quotation marks."""
    header = written.read_text().split("\n")[0]
    assert header.startswith(f"{THEIRS},")
    assert header == ",".join(COLUMNS)


def test_recording_is_that_of_the_trace(trace, written):
    """Every number that a reward is computed from, bit for bit."""
    found, expected = open_steps(written), open_steps(trace)
    for name in (*EVENTS, *STEPS[1:]):
        assert_array_equal(found[name], expected[name], err_msg=name)
    assert_array_equal(found[PAY], expected["reward/baseline"])
    assert_array_equal(found["start"], expected["step"] == 0)


def test_other_rewards_pay_the_file_what_they_pay_the_trace(trace, written, toys, tmp_path):
    """Also one that remembers."""
    for name in ("arp:k2=2", "aarp", "dense"):
        for path in (trace, written):
            rescore(open_steps(path), [choose(toys, "rewards", name)], tmp_path / f"{path.suffix}.scores", toys)
        one, other = ((tmp_path / f"{path.suffix}.scores").read_bytes() for path in (trace, written))
        assert one == other


def test_prev_best_is_the_value_after_the_step(trace, written):
    """As in the experimenters' second program."""
    run = read_trace(trace)
    assert_array_equal(_columns(written)["prevBest"], np.minimum(run["previous_best"], run["distance"]))


def test_positions_are_in_unity_s_frame(trace, written):
    """A point (x, y, z) of theirs is (z, -x, y) here; y is up."""
    run, columns = read_trace(trace), _columns(written)
    for theirs, ours in (("target", "target"), ("endEff", "end_effector")):
        x, y, z = (columns[f"{theirs} {axis}"] for axis in "xyz")
        for found, axis in zip((z, -x, y), "xyz", strict=True):
            assert_array_equal(found, run[f"{ours}_{axis}"])


def test_cells_are_numbers_alone(written):
    """No spreadsheet takes one for a formula."""
    cells = {cell for line in written.read_text().splitlines()[1:] for cell in line.split(",")}
    assert all(np.isfinite(float(cell)) for cell in cells)
    assert "-0" not in cells
