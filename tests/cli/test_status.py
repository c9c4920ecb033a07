"""``harness status``."""

import json
from pathlib import Path

from harness.experiment import Plan, check_experiment, expand
from harness.record import Store
from harness.record.running import Running, write_running
from harness.registry import load_registry, read_given


def test_a_finished_run_is_all_done(harness, quick):
    """In two lines."""
    harness("run", *quick, "--reward", "arp", "--seeds", "1", "--out", "here")
    answer = harness("status", "here")
    assert (answer.status, answer.err) == (0, "")
    assert answer.out == "here: no run is using it\n2 cells: 2 done\n"


def test_failed_cells_are_named_with_their_reason(harness, quick):
    """And what is to be run yet."""
    harness(
        "run",
        *quick,
        "--algo",
        "wander:then=raise",
        "--reward",
        "arp",
        "--seeds",
        "1",
        "--only",
        "wander:then=raise",
        "--limit",
        "1",
        "--out",
        "here",
    )
    out = harness("status", "here").out
    assert "4 cells: 1 failed, 3 pending" in out
    assert "RuntimeError: the arm fell off" in out


def test_a_running_cell_shows_its_steps(harness, quick, tmp_path):
    """Its speed, and when it last told something."""
    harness("run", *quick, "--reward", "arp", "--seeds", "1", "--limit", "1", "--out", "here")
    store = Store.open(tmp_path / "here")
    cell = store.read_plan().cells[1]
    write_running(store.folder, {cell.id: Running(1000.0, cell.steps // 2, 1010.0)})
    with store.locked():
        answer = harness("status", "here")
    assert "here: a run is using it" in answer.out
    assert f"running: {cell.title}: {cell.steps // 2} of {cell.steps} steps" in answer.out
    assert "left" in answer.out


def test_status_as_json(harness, quick):
    """For programs."""
    harness("run", *quick, "--reward", "arp", "--seeds", "1", "--limit", "1", "--out", "here")
    told = json.loads(harness("status", "here", "--json").out)
    assert [cell["status"] for cell in told["cells"]] == ["done", "pending"]
    assert not told["is_in_use"]


def test_a_folder_that_is_no_experiment_is_refused(harness):
    """In one line."""
    answer = harness("status", "nowhere")
    assert (answer.status, answer.err.count("\n")) == (2, 1)


def test_a_running_training_without_the_end_of_an_episode_is_told(harness, tmp_path):
    """Two seconds after its begin its numbers are known."""
    toy = Path(__file__).parents[1] / "experiment" / "environments" / "toy.py"
    cell = expand(
        check_experiment({"task": "toy", "algo": "random", "steps": 10**6}), load_registry(given=read_given([toy]))
    ).cells[0]
    store = Store.create(tmp_path / "here", Plan("near", (cell,), (), {}))
    shown = []
    for told in (1001.0, 1002.0):
        write_running(store.folder, {cell.id: Running(1000.0, 20_000, told)})
        with store.locked():
            shown.append("no episode has ended in 20,000 steps of training" in harness("status", "here").out)
    assert shown == [False, True]
