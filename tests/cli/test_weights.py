"""``harness score RUNS --reward gentle:effort=0.05``: old runs paid by other weights, without the file."""

import json

import pyarrow.parquet as pq
import pytest
from numpy.testing import assert_allclose

from tests.results.gentle import SOURCE


@pytest.fixture
def runs(trained, quick, tmp_path):
    """A finished experiment of a reward with terms, whose file is gone."""
    (tmp_path / "gentle.py").write_text(SOURCE)
    assert trained("run --reward gentle:effort=5 --plugin gentle.py --seeds 1 --out mine", *quick).status == 0
    return "mine"


def _cell(folder, reward):
    for place in (folder / "mine" / "cells").glob("[!.]*"):
        if json.loads((place / "manifest.json").read_text())["cell"]["reward"]["label"] == reward:
            return place
    raise AssertionError(reward)


def test_runs_are_paid_from_the_columns(harness, runs, tmp_path):
    """Relative to the function's own terms, to 1e-12 as a run's own columns with these weights."""
    harness("score mine --reward gentle:effort=0.05")
    place = _cell(tmp_path, "gentle:effort=5")
    without = pq.read_table(place / "scores.parquet").to_pydict()
    (place / "scores.parquet").unlink()
    assert harness("score mine --reward gentle:effort=0.05 --plugin gentle.py").status == 0
    called = pq.read_table(place / "scores.parquet").to_pydict()
    assert list(without) == list(called)
    for name, values in called.items():
        assert_allclose(without[name], values, rtol=1e-12, atol=1e-12)


def test_a_run_of_another_reward_has_one_clear_reason(harness, runs):
    """It says what to give; the others are paid, and the status says that not all are."""
    answer = harness("score mine --reward gentle:effort=0.05")
    assert answer.status == 1
    (line,) = answer.err.splitlines()
    assert "No reward 'gentle' is installed, and the run tells none of its terms: add --plugin FILE" in line
    assert "gentle:effort=0.05" in answer.out


@pytest.mark.parametrize(
    ("reward", "told"),
    [
        (
            "gentle:efort=1",
            "Reward 'gentle' has no term 'efort' to weigh. It has: reach, effort, dock. Did you mean 'effort'?",
        ),
        ("gentle:effort=much", "effort=much is no weight: give a number from -1e+18"),
        ("gentel:effort=1", "Did you mean 'gentle'?"),
    ],
)
def test_bad_input_is_told_in_one_line(harness, runs, reward, told):
    """What cannot be used ends with status 2 and one line."""
    answer = harness("score mine --reward", reward)
    assert (answer.status, answer.err.count("\n")) == (2, 1)
    assert told in answer.err


def test_files_are_paid_too(harness, runs, tmp_path):
    """A trace by its name."""
    place = _cell(tmp_path, "gentle:effort=5")
    assert harness("score", place / "trace.parquet", "--reward", "gentle").status == 0
    assert "gentle/effort" in pq.read_schema(place / "trace.scores.parquet").names


def test_the_report_says_what_the_terms_paid(harness, runs):
    """Without the file of its own trainings, and why not of others."""
    answer = harness("report mine --details")
    assert "What each term paid: gentle:effort=5" in answer.out
    assert "`dock` never paid in 12 steps." in answer.out
    assert "With baseline n/a: No reward 'gentle' is installed" in " ".join(answer.out.split())


def test_weight_0_is_the_reason_of_a_run_by_it(harness, trained, quick, tmp_path):
    """Though trainings by other rewards, which stand first, have another reason."""
    (tmp_path / "gentle.py").write_text(SOURCE)
    trained("run --reward gentle:effort=0 --plugin gentle.py --seeds 1 --out mine", *quick)
    (line,) = harness("score mine --reward gentle").err.splitlines()
    assert "The term 'effort' was recorded with the weight 0, which cannot be undone" in line
