"""``harness compare`` as it is typed."""

import json
import shutil

from harness.results.two_experiments import Between, Verdict


def test_an_experiment_beside_itself_is_the_same(harness, finished, tmp_path):
    """Status 0."""
    mine = finished(seeds=2)
    shutil.copytree(tmp_path / mine, tmp_path / "again")
    answer = harness("compare", mine, "again")
    assert (answer.status, answer.err) == (0, "")
    assert "THE SAME" in answer.out
    data = json.loads(harness("compare", mine, "again", "--json").out)
    assert [one["verdict"] for one in data["combinations"]] == [Verdict.SAME]


def test_a_regression_ends_with_status_1(harness, finished, monkeypatch):
    """One line says so, for who reads no table."""
    mine = finished(seeds=2)
    monkeypatch.setattr(Between, "regressions", property(lambda found: found.pairs))
    answer = harness("compare", mine, mine)
    assert (answer.status, answer.err.count("\n")) == (1, 1)
    assert "regressions: 1; these policies do worse than before" in answer.err


def test_a_folder_that_is_no_experiment_is_refused(harness, finished):
    """Status 2 and one line."""
    answer = harness("compare", finished(seeds=2), "missing")
    assert (answer.status, answer.out, answer.err.count("\n")) == (2, "", 1)
    assert "No folder 'missing'" in answer.err
