"""What a report says of trainings that go on, by the rows that they have written."""

import json
import re

import pytest

import harness
from harness.cli import main
from harness.record import Store, TraceWriter, partial_folder
from harness.record.cell import Running, write_running
from harness.results import load_results
from harness.results.under_way import so_far

ARM = {"sim": "ideal", "algo": "wander", "reward": "arp", "task": "fd100-reach:horizon=5"}
CARTPOLE = {"algo": "random", "task": "gymnasium:id=CartPole-v1"}


@pytest.fixture(params=[ARM, CARTPOLE], ids=["arm", "environment"])
def begun(request, toys, tmp_path):
    """An experiment of which a run does one cell: its training has rows, and nothing else; the partial folder too."""
    folder = tmp_path / "it"
    harness.run(**request.param, seeds=2, steps=60, evaluation_episodes=1, executor="here", out=folder)
    store = Store(folder)
    cell = store.read_plan().cells[0]
    ended = store.cell_folder(cell)
    partial = ended.with_name(f".{ended.name}.partial")
    ended.rename(partial)
    (partial / "manifest.json").unlink()
    return cell, partial


def _reason(cell, partial):
    (found,) = [it for it in load_results(partial.parents[1]).manifests if it.cell == cell]
    assert found.status == "pending"
    return found.reason


def test_report_tells_the_rows_that_are_there(begun):
    """How many steps, and what the last episodes came to; the cell counts as pending all the same."""
    cell, partial = begun
    told = _reason(cell, partial)
    assert told.startswith(f"{cell.title}: 60 of 60 steps recorded; its last ")
    assert re.search(r"its last \d+ episodes were paid -?[\d.e+-]+ on average", told)


def test_status_tells_the_same_rows(begun, capsys):
    """What a report says of them, and the numbers for programs."""
    cell, partial = begun
    told, folder = _reason(cell, partial), partial.parents[1]
    write_running(folder, {cell.id: Running(100.0, 6, 103.0)})
    for flags in ([], ["--json"]):
        with pytest.raises(SystemExit):
            main(["status", str(folder), *flags])
    said, _, numbers = capsys.readouterr().out.partition("{")
    assert f"interrupted: {told}; run" in " ".join(said.split())
    (shown,) = [it for it in json.loads(f"{{{numbers}")["cells"] if it["id"] == cell.id]
    assert shown["recorded"] == 60
    assert f"were paid {shown['mean_return']:.4g} on average" in shown["text"]


def test_a_trace_without_rows_tells_that(make_cell, tmp_path):
    """A training has a trace before its first step."""
    cell, store = make_cell(), Store(tmp_path)
    folder = partial_folder(store.cell_folder(cell))
    folder.mkdir(parents=True)
    TraceWriter(folder / "trace.parquet", 2, 2).keep()
    assert so_far(cell, store).text == f"0 of {cell.steps} steps recorded, and no episode has ended"


def test_damaged_rows_are_told(begun):
    """With the file, and no report is stopped by them."""
    cell, partial = begun
    (path, *_) = (*partial.glob("trace.parquet"), *partial.glob("training/recording-0.json"))
    path.write_bytes(b"half")
    assert path.name in _reason(cell, partial)


def test_cell_that_has_recorded_nothing_is_not_run_yet(begun):
    """A partial folder alone tells nothing."""
    cell, partial = begun
    for path in (*partial.glob("trace.parquet"), *partial.glob("training/*")):
        path.unlink()
    assert _reason(cell, partial) == "not run yet"
