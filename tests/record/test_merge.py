"""Several folders become one."""

import json
import os
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from harness.errors import UsageError
from harness.experiment.plan import Plan, check_experiment, expand
from harness.record.cell import Cell
from harness.record.folder import DERIVED, MANIFEST, TRACE
from harness.record.manifest import read_manifest
from harness.record.merge import merge
from harness.record.plan_file import EXPERIMENT, PLAN, read_plan
from harness.record.store import CELLS, LOCK, REPORT, RESULTS, Store
from harness.record.terms import FIRST, Terms
from harness.record.verify import verify
from harness.registry.registry import Registry
from harness.report.document import report_text
from harness.results import Results, load_results
from harness_plugins.transfer.record import TRANSFER

Run = Callable[..., Path]


@pytest.fixture
def run(toys: Registry, run_once: Callable[..., Results], tmp_path: Path) -> Run:
    """Gives a folder of that name with an experiment of these seeds, done; one that was done before is copied."""

    def run_into(name: str, seeds: Any, **keys: Any) -> Path:
        asked = {
            "sim": ["ideal"],
            "algo": ["wander"],
            "reward": ["arp"],
            "task": "fd100-reach:horizon=5",
            "steps": 6,
            **keys,
        }
        plan = expand(check_experiment({**asked, "evaluation_episodes": 2, "seeds": seeds}), toys)
        return run_once(plan, tmp_path / name).folder

    return run_into


def _files(folder: Path) -> dict[str, bytes]:
    files = [path for path in folder.rglob("*") if path.is_file() and path.name != LOCK]
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def _fail(folder: Path, cell: Cell) -> None:
    shutil.rmtree(folder / CELLS / cell.id)
    Store(folder).record(cell, "failed", "no luck")


def test_report_is_that_of_one_run(run: Run, tmp_path: Path):
    """Byte for byte, whatever the order of the folders; times are those of the cells."""
    whole = run("whole", 4)
    parts = [run("one", [0, 2]), run("two", [1, 3])]
    merge(parts[::-1], tmp_path / "all")
    for cell in read_plan(whole).cells:  # the same trainings at another time; each part has its random actions
        shutil.copytree(tmp_path / "all" / CELLS / cell.id, whole / CELLS / cell.id, dirs_exist_ok=True)
    assert report_text(load_results(tmp_path / "all")) == report_text(load_results(whole))
    assert verify(tmp_path / "all") == []


def test_experiment_asks_for_all(run: Run, tmp_path: Path):
    """Where the parts differ in one list; the same run then finds every cell done."""
    merge([run("one", [0, 1]), run("two", [1, 2])], tmp_path / "all")
    assert load_results(tmp_path / "all").plan.experiment["seeds"] == [0, 1, 2]
    assert "seeds = [\n    0,\n    1,\n    2,\n]" in (tmp_path / "all" / EXPERIMENT).read_text()


def test_names_are_united(run: Run, tmp_path: Path):
    """As seeds are."""
    merge([run("one", 1, reward=["arp"]), run("two", 1, reward=["dense", "arp"])], tmp_path / "all")
    plan = read_plan(tmp_path / "all")
    assert [reward["name"] for reward in plan.experiment["reward"]] == ["arp", "dense"]
    assert [cell.reward.name for cell in plan.cells] == ["baseline", "arp", "dense"]


def test_experiments_that_differ_in_more_stand_one_after_the_other(run: Run, tmp_path: Path):
    """As in a folder where both were run; the last one is the newest."""
    one, two = run("one", [0]), run("two", [1], steps=12)
    merge([one, two], tmp_path / "all")
    plan = read_plan(tmp_path / "all")
    assert plan.experiment == read_plan(two).experiment
    assert plan.cells == (*read_plan(one).cells, *read_plan(two).cells)


def test_sources_stay_as_they_were(run: Run, tmp_path: Path):
    """Every byte of them."""
    folders = [run("one", [0]), run("two", [1])]
    before = [_files(folder) for folder in folders]
    merge(folders, tmp_path / "all")
    assert [_files(folder) for folder in folders] == before


def test_tables_and_pages_are_not_copied(run: Run, tmp_path: Path):
    """Cells are whole, and what is kept of them comes with them."""
    one = run("one", [0])
    for name in (RESULTS, REPORT):
        (one / name).write_text("made")
    assert (one / DERIVED).is_dir()
    merge([one], tmp_path / "all")
    cells = {name: content for name, content in _files(one).items() if name.startswith((CELLS, DERIVED))}
    assert _files(tmp_path / "all") == {**cells, **{name: (one / name).read_bytes() for name in (PLAN, EXPERIMENT)}}


def test_cell_that_is_done_in_both_is_taken_once(run: Run, tmp_path: Path):
    """It has the same trace in both; the first folder's is taken."""
    one, two = run("one", [0]), run("two", [0, 1])
    merge([one, two], tmp_path / "all")
    [cell, *_] = read_plan(one).cells
    assert _files(tmp_path / "all" / CELLS / cell.id) == _files(one / CELLS / cell.id)
    assert len(Store(tmp_path / "all").manifests()) == 4


@pytest.mark.parametrize("order", [1, -1])
def test_done_cell_wins_over_a_failed_one(run: Run, tmp_path: Path, order: int):
    """Whichever comes first."""
    one, two = run("one", [0]), run("two", [0])
    cell = read_plan(one).cells[0]
    _fail(one, cell)
    merge([one, two][::order], tmp_path / "all")
    assert Store(tmp_path / "all").is_done(cell)


def test_failed_and_pending_cells_stay_so(run: Run, tmp_path: Path):
    """The merged folder tells of them as the parts did."""
    one, two = run("one", [0]), run("two", [1])
    _fail(one, read_plan(one).cells[0])
    shutil.rmtree(two / CELLS / read_plan(two).cells[0].id)
    merge([one, two], tmp_path / "all")
    assert [item.status for item in load_results(tmp_path / "all").manifests] == ["failed", "done", "pending", "done"]


def test_two_trainings_that_differ_are_refused(run: Run, tmp_path: Path):
    """The message names the cell and both folders; nothing is written."""
    one, two = run("one", [0]), run("two", [0])
    cell = read_plan(two).cells[0]
    folder = two / CELLS / cell.id
    shutil.copy(two / CELLS / read_plan(two).cells[1].id / TRACE, folder / TRACE)
    read_manifest(folder).write(folder)
    with pytest.raises(UsageError, match=f"Cell {cell.id} .* was trained in '{one}' and in '{two}', and the steps"):
        merge([one, two], tmp_path / "all")
    assert not (tmp_path / "all").exists()


def test_damaged_cell_is_left_out_and_named(run: Run, tmp_path: Path):
    """It is pending then: the next run does it."""
    one, two = run("one", [0]), run("two", [1])
    cell = read_plan(one).cells[0]
    (one / CELLS / cell.id / TRACE).write_bytes(b"PAR1")
    merged = merge([one, two], tmp_path / "all")
    assert [item.path for item in merged.left_out] == [one / CELLS / cell.id]
    assert "is not what was written" in merged.left_out[0].reason
    assert Store(tmp_path / "all").examine(cell).status == "pending"


def test_sound_cell_is_taken_in_place_of_a_damaged_one(run: Run, tmp_path: Path):
    """And the damaged one is named all the same."""
    one, two = run("one", [0]), run("two", [0])
    cell = read_plan(one).cells[0]
    (one / CELLS / cell.id / TRACE).write_bytes(b"PAR1")
    assert len(merge([one, two], tmp_path / "all").left_out) == 1
    assert Store(tmp_path / "all").is_done(cell)


def test_experiment_s_folder_keeps_what_it_has(run: Run, tmp_path: Path):
    """Cells of the others come to its own."""
    one, two = run("one", [0]), run("two", [1])
    before = _files(one / CELLS)
    merge([two], one)
    assert before.items() <= _files(one / CELLS).items()
    assert [item.cell.seed for item in load_results(one).done] == [0, 0, 1, 1]


def test_merging_again_changes_nothing(run: Run, tmp_path: Path):
    """A merge that was cut short goes on by the same call."""
    one, two = run("one", [0]), run("two", [1])
    merge([one, two], tmp_path / "all")
    before = _files(tmp_path / "all")
    merge([one, two], tmp_path / "all")
    assert _files(tmp_path / "all") == before


def test_transfers_are_copied(ran: Path, tmp_path: Path):
    """With their cells."""
    merge([ran], tmp_path / "all")
    assert _files(ran / TRANSFER)
    assert _files(tmp_path / "all" / TRANSFER) == _files(ran / TRANSFER)


def test_damaged_transfer_is_left_out_and_named(ran: Path, tmp_path: Path):
    """Its cell is not."""
    [folder] = (ran / TRANSFER).glob("*/*")
    (folder / MANIFEST).write_text("{")
    [left] = merge([ran], tmp_path / "all").left_out
    assert left.path == folder
    assert not (tmp_path / "all" / TRANSFER).exists()
    assert (tmp_path / "all" / CELLS / folder.parent.name).is_dir()


def test_other_baselines_are_refused(run: Run, tmp_path: Path):
    """Nothing says what the merged comparison would be with."""
    one, two = run("one", [0]), run("two", [0], baseline="dense")
    with pytest.raises(UsageError, match=r"compares with baseline, '.*two' with dense"):
        merge([one, two], tmp_path / "all")
    assert not (tmp_path / "all").exists()


def test_folder_that_is_no_experiment_is_refused(run: Run, tmp_path: Path):
    """Before anything is written."""
    (tmp_path / "notes").mkdir()
    with pytest.raises(UsageError, match="notes' is no experiment"):
        merge([run("one", [0]), tmp_path / "notes"], tmp_path / "all")
    assert not (tmp_path / "all").exists()


def test_folder_with_other_things_is_not_merged_into(run: Run, tmp_path: Path):
    """It stays as it is."""
    (tmp_path / "notes").mkdir()
    (tmp_path / "notes" / "mine.txt").write_text("kept")
    with pytest.raises(UsageError, match="holds something else than an experiment"):
        merge([run("one", [0])], tmp_path / "notes")
    assert _files(tmp_path / "notes") == {"mine.txt": b"kept"}


@pytest.mark.skipif(os.name == "nt", reason="links take a privilege there")
def test_links_are_not_followed(run: Run, tmp_path: Path):
    """A stranger's folder may lead anywhere."""
    one = run("one", [0])
    cell = read_plan(one).cells[0]
    (one / CELLS / cell.id / "policy" / "mine").symlink_to("/etc/hostname")
    with pytest.raises(UsageError, match="is a link; nothing is merged from a folder with links"):
        merge([one], tmp_path / "all")
    assert not (tmp_path / "all").exists()


def test_number_of_seeds_that_no_cell_has_is_no_list(
    make_cell: Callable[..., Cell], make_plan: Callable[..., Plan], tmp_path: Path
):
    """A stranger's plan may claim any number."""
    for name in ("one", "two"):
        plan = make_plan(make_cell())
        Store.create(tmp_path / name, replace(plan, resolved={**plan.resolved, "seeds": 10**12}))
    merge([tmp_path / "one", tmp_path / "two"], tmp_path / "all")
    assert json.loads((tmp_path / "all" / PLAN).read_text())["experiment"]["seeds"] == 10**12


def test_what_was_added_later_stays_told(run: Run, tmp_path: Path):
    """Of either folder, and what both agreed on besides."""
    one, other = run("one", [0, 1]), run("two", [2, 3])
    for folder, added in ((one, Terms(averaged=5, grown=(2,))), (other, Terms(averaged=5, joined=("arp",)))):
        replace(read_plan(folder), terms=added).write(folder)
    merge([one, other], tmp_path / "all")
    assert read_plan(tmp_path / "all").terms == Terms(averaged=5, grown=(2,), joined=("arp",))


def test_other_terms_are_those_of_no_plan(run: Run, tmp_path: Path):
    """Trainings in looks beside such of all seeds at once."""
    one, other = run("one", [0, 1]), run("two", [2, 3])
    replace(read_plan(one), terms=Terms((2, 4), averaged=5)).write(one)
    merge([one, other], tmp_path / "all")
    assert read_plan(tmp_path / "all").terms == FIRST
