"""From names to tuned settings."""

import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

from harness.errors import UsageError
from harness.experiment.plan import expand, read_experiment
from harness.record.manifest import read_manifest
from harness_plugins.tune.tune import tune
from harness_plugins.tune.tuning import FIRST_SEED

WAITING = 120.0


def _cells(folder: Path) -> list:
    return [read_manifest(path) for path in (folder / "trials" / "cells").glob("[!.]*")]


def _values(tuned) -> list:
    return [[(trial.params, trial.outcome, trial.status) for trial in search.trials] for search in tuned.searches]


def test_best_setting_is_found(tune_here):
    """The arm reaches more the more effort it makes: the best trial is the one with the most."""
    (search,) = tune_here(trials=4).searches
    assert search.best == max(search.trials, key=lambda trial: trial.params["effort"])
    assert search.best.outcome.success > search.trials[0].outcome.success == 0.0


def test_tuned_file_is_an_experiment(tune_here, toys):
    """It expands to cells with the best settings, under every reward, with the seeds of a run."""
    tuned = tune_here()
    plan = expand(read_experiment(tuned.file, {}), toys)
    (algorithm,) = {cell.algorithm for cell in plan.cells}
    assert dict(algorithm.params)["effort"] == tuned.searches[0].best.params["effort"]
    assert {cell.reward.label for cell in plan.cells} == {"baseline", "arp"}
    assert {cell.seed for cell in plan.cells} == set(range(6))
    assert {(cell.steps, cell.task.label) for cell in plan.cells} == {(2, "fd100-reach:epsilon=0.2,horizon=5")}


def test_budgets_are_equal_for_every_reward(tune_here, tmp_path):
    """Jointly and per reward: as many trainings, of the same steps and seeds."""
    for per_reward in (False, True):
        tune_here(out=tmp_path / str(per_reward), per_reward=per_reward, seeds=2, trials=2)
        budgets = {}
        for manifest in _cells(tmp_path / str(per_reward)):
            cell = manifest.cell
            budgets.setdefault(cell.reward.label, Counter())[cell.seed, cell.steps] += 1
        assert budgets["baseline"] == budgets["arp"] == Counter({(FIRST_SEED, 2): 2, (FIRST_SEED + 1, 2): 2})


def test_per_reward_searches_draw_from_the_same_seed(tune_here):
    """Two rewards that train alike meet the same trials and the same choice, whatever the scale of what they pay."""
    tuned = tune_here(reward="scaled:reward=baseline,factor=1000", per_reward=True)
    one, other = _values(tuned)
    assert one == other
    assert tuned.searches[0].best == tuned.searches[1].best


def test_tuned_file_of_several_searches_has_every_choice(tune_here, toys):
    """An experiment is a full matrix: each reward meets each choice."""
    tuned = tune_here(per_reward=True, algo="sweep:effort=1", trials=1)
    plan = expand(read_experiment(tuned.file, {}), toys)
    assert {(cell.algorithm.label, cell.reward.label) for cell in plan.cells} == {
        ("sweep:effort=1", "baseline"), ("sweep:effort=1", "arp"),
    }  # fmt: skip
    text = tuned.file.read_text()
    assert "# baseline: trial 0, effort=1.0" in text
    assert "# arp: trial 0, effort=1.0" in text


def test_same_call_gives_the_same_trials(tune_here, tmp_path):
    """In another folder too, and with other numbers of jobs."""
    first, second = tune_here(out=tmp_path / "a"), tune_here(out=tmp_path / "b", jobs=3)
    assert _values(first) == _values(second)


def test_second_call_runs_nothing(tune_here, tmp_path):
    """It says what the first said, and no cell was touched."""
    first = tune_here()
    started = {manifest.cell.id: manifest.started for manifest in _cells(tmp_path / "tuning")}
    second = tune_here()
    assert _values(first) == _values(second)
    assert {manifest.cell.id: manifest.started for manifest in _cells(tmp_path / "tuning")} == started


def test_failed_cells_are_failed_trials(tune_here):
    """With their reasons; the best is one of the others."""
    tuned = tune_here(algo="sweep:breaks_above=0.5", trials=5)
    assert tuned.failed
    assert {trial.reason for trial in tuned.failed} == {"RuntimeError: the arm fell off"}
    assert tuned.searches[0].best.params["effort"] <= 0.5


def test_no_complete_trial_leaves_no_file(tune_here):
    """Nothing is recommended where nothing was seen to the end."""
    tuned = tune_here(search={"effort": "0.6..1"}, algo="sweep:breaks_above=0.5", trials=2)
    assert (tuned.file, tuned.searches[0].best, len(tuned.failed)) == (None, None, 2)


def test_results_are_plain_data(tune_here):
    """What the command prints can be read by anybody."""
    tuned = tune_here(search={"effort": "0..1", "layers": "4|8x8"}, trials=2)
    data = json.loads(json.dumps(tuned.to_json(), allow_nan=False))
    assert data["searches"][0]["rewards"] == ["baseline", "arp"]
    assert data["searches"][0]["trials"][0]["params"] == {"effort": 0.0, "layers": [4]}
    assert data["file"] == str(tuned.file)


@pytest.mark.parametrize("key", ["steps", "validation_episodes", "seed", "batch"])
def test_another_search_does_not_go_into_the_same_folder(tune_here, key):
    """It would mix trials that cannot be compared; the key is named."""
    tune_here(trials=1)
    with pytest.raises(UsageError, match=f"holds another search: {key} was"):
        tune_here(trials=1, **{key: 4})


def test_trials_of_other_plugins_are_not_compared_with_new_ones(tune_here, tmp_path):
    """A search that is over is shown as ever; one that would go on is refused, and nothing is run."""
    before = tune_here(trials=1)
    for manifest in _cells(tmp_path / "tuning"):
        sources = {**manifest.environment["sources"], "algorithms": "9340a572" * 8}
        edited = replace(manifest, environment={**manifest.environment, "sources": sources})
        edited.write(tmp_path / "tuning" / "trials" / "cells" / manifest.cell.id)
    assert _values(tune_here(trials=1)) == _values(before)
    told = r"2 done cells were made by another sweep \(9340a572, now [0-9a-f]{8}\): another --out searches anew"
    with pytest.raises(UsageError, match=told):
        tune_here(trials=2)
    assert len(_cells(tmp_path / "tuning")) == 2


def test_foreign_folders_are_left_alone(tune_here, tmp_path):
    """A folder that holds something else is refused, with nothing written."""
    (tmp_path / "thesis.txt").write_text("all of it")
    with pytest.raises(UsageError, match="something else than a tuning"):
        tune_here(out=tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.txt"]


def test_folder_in_use_is_refused(tune_here, tmp_path):
    """Two searches at once would spoil the journal."""
    import fcntl

    tune_here(trials=1)
    with (tmp_path / "tuning" / ".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        with pytest.raises(UsageError, match="Another search is using"):
            tune_here(trials=2)


def test_killed_search_goes_on_where_it_stopped(toys, make_setup, tune_here, tmp_path):
    """After SIGKILL in the midst of a training: finished cells are not run again, the trials are those of no kill."""
    hold, out = tmp_path / "hold", tmp_path / "killed"
    keys = {"algo": f"sweep:hold={hold}", "trials": 3, "jobs": 1, "out": str(out)}
    quick = {"sim": "ideal", "reward": "arp", "task": "fd100-reach:epsilon=0.2,horizon=5",
             "search": {"effort": "0..1"}, "seeds": 1, "steps": 2, "validation_episodes": 10}  # fmt: skip
    script = f"from harness_plugins.tune.tune import tune; tune(**{ {**quick, **keys}!r})"
    with (tmp_path / "told").open("w") as told:
        process = subprocess.Popen([sys.executable, "-c", script], stderr=told, cwd=tmp_path)
    _wait_until(lambda: (out / "study.log").exists() and len(_cells(out)) >= 3, process)
    hold.write_text("")
    _wait_until(lambda: any((out / "trials" / "cells").glob(".*.partial")), process)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    hold.unlink()
    before = {manifest.cell.id: manifest.started for manifest in _cells(out)}
    assert 3 <= len(before) < 6
    tuned = tune(**quick, **keys)
    after = {manifest.cell.id: manifest.started for manifest in _cells(out)}
    assert before.items() <= after.items()
    assert len(after) == 6
    assert _values(tuned) == _values(tune_here(**{**quick, **keys, "out": tmp_path / "whole"}))


def _wait_until(happened, process) -> None:
    end = time.monotonic() + WAITING
    while not happened():
        assert process.poll() is None, "the search ended too early"
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.02)
