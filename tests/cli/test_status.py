"""``harness status``."""

import json

from harness.record import Store


def test_a_finished_run_is_all_done(harness, experiment):
    """In two lines."""
    answer = harness("status mine")
    assert (answer.status, answer.err) == (0, "")
    assert answer.out == "mine: no run is using it\n2 cells: 2 done\n"


def test_failed_cells_are_named_with_their_reason(harness, quick):
    """And what is to be run yet."""
    harness("run --algo wander:then=raise --reward arp --seeds 1 --only wander:then=raise --limit 1 --out here", *quick)
    out = harness("status here").out
    assert "4 cells: 1 failed, 3 pending" in out
    assert "RuntimeError: the arm fell off" in out


def note(store, **told):
    """Write down that the last cell is running, as a run does."""
    (store.folder / "running.json").write_text(json.dumps({store.read_plan().cells[-1].id: told}))


def test_a_running_cell_shows_its_steps(harness, quick, tmp_path):
    """Its speed, and when it last told something."""
    harness("run --reward arp --seeds 1 --limit 1 --out here", *quick)
    store = Store.open(tmp_path / "here")
    cell = store.read_plan().cells[1]
    note(store, started=1000.0, steps=cell.steps // 2, told=1010.0)
    with store.locked():
        answer = harness("status here")
    assert "here: a run is using it" in answer.out
    assert f"running: {cell.title}: {cell.steps // 2} of {cell.steps} steps" in answer.out
    assert "left" in answer.out


def test_status_as_json(harness, quick):
    """For programs."""
    harness("run --reward arp --seeds 1 --limit 1 --out here", *quick)
    told = harness("status here --json").json
    assert [cell["status"] for cell in told["cells"]] == ["done", "pending"]
    assert not told["is_in_use"]
