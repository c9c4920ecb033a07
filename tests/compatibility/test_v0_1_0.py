"""An experiment's folder that version 0.1.0 left is reported, scored and resumed as before.

``v0.1.0`` was made by that version with::

    harness run --sim kinematic --algo sac-fast:net_arch=8x8,gamma=0.9,learning_starts=50 --reward arp --seeds 2
        --task fd100-reach:horizon=25 --steps 120 --evaluation-episodes 2 --evaluate-every 60 --out v0.1.0
    harness transfer v0.1.0 --to mujoco
    harness score v0.1.0 --reward dense --all --json > score.json

``report.json`` was made by ``harness report v0.1.0 --json`` after the statistics had changed: indices, etas, both paths
of their split and the means of all measures stayed as they were, intervals and p-values did not. From 0.4.0 on a mean
is told as ``value``.
"""

import json
import shutil
from pathlib import Path

import pytest
from numpy.testing import assert_allclose, assert_array_equal

from harness.cli import main
from harness.experiment.experiment import prepare
from harness.experiment.plan import read_experiment
from harness.experiment.run_options import RunOptions
from harness.record.cell import read_manifest
from harness.record.folder import TRACE
from harness.record.store import EXPERIMENT, Store
from harness.record.trace import read_trace
from harness.text import LONGEST_MESSAGE
from tests.arithmetic import arithmetic
from tests.refusals import refused

HERE = Path(__file__).parent
LEFT = HERE / "v0.1.0"
MADE_WITH = "2.4.6 1.4.0 3.17.0 linux 5523dc0f0f6ebca3"
CELLS = sorted(path.name for path in (LEFT / "cells").iterdir())


@pytest.fixture
def old(tmp_path):
    """A copy of the folder, to be written into."""
    return Path(shutil.copytree(LEFT, tmp_path / "old"))


def _resume(folder):
    """Run the folder's own experiment file again, in it; the plugins were edited since."""
    events = []
    run = prepare(read_experiment(folder / EXPERIMENT, {}), RunOptions(out=folder, jobs=1, changed="keep"))
    run.run(events.append)
    return run, events


def _leaves(data, path=""):
    """Every number and text of plain data, with where it stands."""
    if isinstance(data, dict):
        for key, value in data.items():
            yield from _leaves(value, f"{path}/{key}")
    elif isinstance(data, list):
        for index, value in enumerate(data):
            yield from _leaves(value, f"{path}/{index}")
    else:
        yield path, data


def _known(found, before):
    """Of `found` what `before` has as well: keys, and metrics in a list, that came since are left out."""
    if isinstance(found, dict) and isinstance(before, dict):
        return {key: _known(value, before[key]) for key, value in found.items() if key in before}
    if not isinstance(found, list) or not isinstance(before, list):
        return found
    names = [item.get("name") for item in before if isinstance(item, dict)]
    kept = [item for item in found if not isinstance(item, dict) or item.get("name") in names]
    return [_known(*pair) for pair in zip(kept, before, strict=True)] if len(kept) == len(before) else found


def _require_equal(found, expected):
    """The same keys and texts; numbers up to their last digits, in which another machine may differ."""
    leaves, before = dict(_leaves(found)), dict(_leaves(expected))
    assert leaves.keys() == before.keys()
    for path, value in before.items():
        is_number = isinstance(value, float)
        assert leaves[path] == (pytest.approx(value, rel=1e-9, abs=1e-12) if is_number else value), path


def _printed(capsys, *arguments):
    """The JSON that a command prints."""
    with pytest.raises(SystemExit) as stopped:
        main([*map(str, arguments), "--json"])
    assert not stopped.value.code
    return json.loads(capsys.readouterr().out)


def test_report_says_what_it_said(old, capsys):
    """Every key, text and number of `harness report --json`, transfer and learning curves included.

    The answer about the robot is the one of today's rule: `report.json` was given it by hand.
    """
    before = json.loads((HERE / "report.json").read_text())
    _require_equal(_known(_printed(capsys, "report", old), before), before)


def test_score_pays_what_it_paid(old, capsys):
    """Every index of every training under every reward; the columns that were there are kept."""
    found = _printed(capsys, "score", old, "--reward", "dense", "--all")
    before = json.loads((HERE / "score.json").read_text())
    _require_equal(_known(found, before), before)


@pytest.mark.parametrize("name", CELLS)
def test_cell_has_the_id_that_it_had(name):
    """The hash of its content is the name of its folder."""
    assert read_manifest(LEFT / "cells" / name).cell.id == name


@pytest.mark.parametrize("name", CELLS)
def test_manifest_is_written_as_it_was(name, tmp_path):
    """Read and written again it has the same keys and values, and names its files besides."""
    read_manifest(LEFT / "cells" / name).write(tmp_path)
    [before, after] = [
        json.loads((folder / "manifest.json").read_text()) for folder in (LEFT / "cells" / name, tmp_path)
    ]
    del after["files"], after["digest"]
    assert after == {**before, "format": 2, "peak_memory": 0}


def test_new_cells_are_not_mixed_with_those_of_then_in_silence(old):
    """The plugins were edited since: one line says so, and what can be done."""
    asked = prepare(read_experiment(old / EXPERIMENT, {}), RunOptions(out=old, jobs=1))
    with refused(r"4 done cells were made by another .*--changed keep") as told:
        asked.run()
    assert len(str(told.value)) <= LONGEST_MESSAGE


def test_nothing_is_run_again(old):
    """The same experiment finds all of its cells done."""
    run, events = _resume(old)
    assert sorted(cell.id for cell in run.plan.cells if run.store.examine(cell).status == "done") == CELLS
    assert events == []


def test_missing_cell_is_done_again(old):
    """With the same rows: the first sixty, ten of a learner that learns, to rounding; all in bits where operations are.

    The folder was made with OpenBLAS's kernel for Haswell.
    """
    cell = Store.open(old).read_plan().cells[1]
    folder = Store.open(old).cell_folder(cell)
    then = read_trace(folder / TRACE).load()
    shutil.rmtree(folder)
    _, events = _resume(old)
    assert {event.cell for event in events} == {cell}
    assert read_manifest(folder).status == "done"
    found = read_trace(folder / TRACE).load()
    assert found.columns == then.columns
    for name in then.columns:
        if arithmetic() == MADE_WITH:
            assert_array_equal(found[name], then[name], err_msg=name)
        assert_allclose(found[name][:60], then[name][:60], rtol=0.0, atol=1e-6, err_msg=name)
