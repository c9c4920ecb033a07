"""Several folders become one."""

import json
import os
import shutil
from dataclasses import replace

import pytest

from harness import load_results
from harness.errors import UsageError
from harness.experiment.plan import check_experiment, expand
from harness.experiment.verify import verify
from harness.record import (
    EVALUATION,
    EXPERIMENT,
    LOG,
    MANIFEST,
    PLAN,
    RANDOM,
    REPORT,
    RESULTS,
    TRACE,
    Store,
    Terms,
    read_manifest,
)
from harness.record.merge import merge
from harness.report import Report, report_text
from harness_plugins.transfer.record import read_record_of
from tests.stores import create_store

ASKED = {"sim": "ideal", "algo": "wander", "reward": "arp", "task": "fd100-reach:horizon=5", "steps": 6}


@pytest.fixture
def run(toys, run_once, tmp_path):
    """Gives a folder of that name with an experiment of these seeds, done; one that was done before is copied."""

    def run_into(name, seeds, **keys):
        plan = expand(check_experiment({**ASKED, **keys, "evaluation_episodes": 2, "seeds": seeds}), toys)
        return run_once(plan, tmp_path / name).folder

    return run_into


@pytest.fixture
def merged(tmp_path):
    """What merging folders into a new one said, and left there."""

    def merged(*folders):
        said = merge(folders, tmp_path / "all")
        return said, Store(tmp_path / "all")

    return merged


@pytest.fixture
def refused(tmp_path):
    """See that folders are not merged, for this reason, and that nothing is written."""

    def refused(folders, told):
        with pytest.raises(UsageError, match=told):
            merge(folders, tmp_path / "all")
        assert not (tmp_path / "all").exists()

    return refused


def _files(folder):
    files = [path for path in folder.rglob("*") if path.is_file() and path.name != ".lock"]
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def _cells(folder):
    """The folders of its cells, in the order of the plan."""
    store = Store(folder)
    return [store.cell_folder(cell) for cell in store.read_plan().cells]


def _change(cell, name):
    """One byte more in a file of a done cell, as another machine would have left it."""
    with (cell / name).open("ab") as file:
        file.write(b" ")
    read_manifest(cell).write(cell)


def _fail(folder):
    first = _cells(folder)[0]
    cell = read_manifest(first).cell
    shutil.rmtree(first)
    Store(folder).record(cell, "failed", "no luck")


def test_report_is_that_of_one_run(run, merged, tmp_path):
    """Byte for byte, whatever the order of the folders; times are those of the cells."""
    whole = run("whole", 4)
    merged(run("two", [1, 3]), run("one", [0, 2]))
    for folder in _cells(whole):  # the same trainings at another time; each part has its random actions
        shutil.copytree(tmp_path / "all" / "cells" / folder.name, folder, dirs_exist_ok=True)
    assert report_text(Report(load_results(tmp_path / "all"))) == report_text(Report(load_results(whole)))
    assert verify(tmp_path / "all") == []


def test_experiment_asks_for_all(run, merged):
    """Where the parts differ in one list; a cell that is done in both is taken once, from the first folder."""
    one = run("one", [0, 1])
    _, store = merged(one, run("two", [1, 2]))
    assert store.read_plan().experiment["seeds"] == [0, 1, 2]
    assert "seeds = [\n    0,\n    1,\n    2,\n]" in (store.folder / EXPERIMENT).read_text()
    assert all(_files(folder) == _files(store.folder / "cells" / folder.name) for folder in _cells(one))
    assert len(store.manifests()) == 6


def test_names_are_united(run, merged):
    """As seeds are."""
    _, store = merged(run("one", 1, reward=["arp"]), run("two", 1, reward=["dense", "arp"]))
    plan = store.read_plan()
    assert [reward["name"] for reward in plan.experiment["reward"]] == ["arp", "dense"]
    assert [cell.reward.name for cell in plan.cells] == ["baseline", "arp", "dense"]


def test_experiments_that_differ_in_more_stand_one_after_the_other(run, merged):
    """As in a folder where both were run; the last one is the newest."""
    one, two = run("one", [0]), run("two", [1], steps=12)
    _, store = merged(one, two)
    first, second, plan = (Store(folder).read_plan() for folder in (one, two, store.folder))
    assert (plan.experiment, plan.cells) == (second.experiment, (*first.cells, *second.cells))


def test_sources_stay_as_they_were(run, merged):
    """Every byte; of a folder cells and what is kept of them are copied, tables and pages are not."""
    one = run("one", [0])
    for name in (RESULTS, REPORT):
        (one / name).write_text("made")
    before = _files(one)
    _, store = merged(one)
    assert _files(one) == before
    assert (one / "derived").is_dir()
    kept = {
        name: content for name, content in before.items() if name.startswith(("cells", "derived", PLAN, EXPERIMENT))
    }
    assert _files(store.folder) == kept


@pytest.mark.parametrize("order", [1, -1])
def test_done_cell_wins_over_a_failed_one(run, merged, order):
    """Whichever comes first."""
    one, two = run("one", [0]), run("two", [0])
    _fail(one)
    _, store = merged(*[one, two][::order])
    assert [it.status for it in store.manifests()] == ["done", "done"]


def test_failed_and_pending_cells_stay_so(run, merged):
    """The merged folder tells of them as the parts did."""
    one, two = run("one", [0]), run("two", [1])
    _fail(one)
    shutil.rmtree(_cells(two)[0])
    _, store = merged(one, two)
    assert [item.status for item in load_results(store.folder).manifests] == ["failed", "done", "pending", "done"]


@pytest.mark.parametrize(
    "name",
    [TRACE, EVALUATION, "stochastic.parquet", RANDOM, "scene.json", "policy/weights.safetensors", "policy/card.json"],
)
def test_cell_with_a_file_that_differs_is_refused(run, refused, name):
    """Else a report would depend on the order of the folders. The message names the cell, both folders and the file."""
    one, two = run("one", [0]), run("two", [0])
    folder = next(it for it in _cells(two) if (it / name).exists())
    _change(folder, name)
    refused(
        [one, two],
        rf"Cell {folder.name} .* is done in '{one}/cells/{folder.name}' and in '{folder}', and {name} is not the same",
    )


def test_cells_may_differ_in_what_tells_times(run, merged):
    """And in whether they left what random actions did: one of several cells does."""
    one, two = run("one", [0]), run("two", [0])
    for folder in _cells(two):
        _change(folder, LOG)
    [floor] = two.glob(f"cells/*/{RANDOM}")
    floor.unlink()
    read_manifest(floor.parent).write(floor.parent)
    _, store = merged(one, two)
    assert _files(store.folder / "cells") == _files(one / "cells")


def test_added_folder_that_differs_is_refused(ran, refused, tmp_path):
    """As a cell is."""
    other = shutil.copytree(ran, tmp_path / "other")
    [folder] = (other / "transfer").glob("*/*")
    record = read_record_of(folder)
    (folder / EVALUATION).write_bytes(b"others")
    record.write(folder)
    place = folder.relative_to(other)
    refused([ran, other], f"{place} is done in '{ran / place}' and in '{folder}', and {EVALUATION} is not the same")


@pytest.mark.parametrize(("seeds", "status"), [([1], "pending"), ([0], "done")])
def test_damaged_cell_is_left_out_and_named(run, merged, seeds, status):
    """The next run does it; a sound one is taken in its place."""
    one, two = run("one", [0]), run("two", seeds)
    folder = _cells(one)[0]
    cell = read_manifest(folder).cell
    (folder / TRACE).write_bytes(b"PAR1")
    said, store = merged(one, two)
    [(left, reason)] = said.left_out
    assert (left, "is not what was written" in reason) == (folder, True)
    assert store.examine(cell).status == status


def test_experiment_s_folder_keeps_what_it_has(run):
    """Cells of the others come to its own."""
    one, two = run("one", [0]), run("two", [1])
    before = _files(one / "cells")
    merge([two], one)
    assert before.items() <= _files(one / "cells").items()
    assert [item.cell.seed for item in load_results(one).done] == [0, 0, 1, 1]


def test_merging_again_changes_nothing(run, merged):
    """A merge that was cut short goes on by the same call."""
    folders = [run("one", [0]), run("two", [1])]
    before, after = (_files(merged(*folders)[1].folder) for _ in range(2))
    assert before == after


def test_transfers_are_copied(ran, merged):
    """With their cells; one that is damaged is left out and named, and its cell is not."""
    [folder] = (ran / "transfer").glob("*/*")
    _, store = merged(ran)
    assert _files(store.folder / "transfer") == _files(ran / "transfer") != {}
    shutil.rmtree(store.folder)
    (folder / MANIFEST).write_text("{")
    assert [left for left, _ in merged(ran)[0].left_out] == [folder]
    assert not (store.folder / "transfer").exists()
    assert (store.folder / "cells" / folder.parent.name).is_dir()


def test_plan_that_was_cut_is_marked_wherever_it_was_cut(run, tmp_path):
    """At 40 lengths, whatever the order of the folders: nobody knows what is missing, so there is no verdict."""
    one, two = run("one", [0, 1]), run("two", [2, 3])
    shutil.rmtree(_cells(one)[0])
    whole, silent = (one / PLAN).read_bytes(), []
    for length in range(0, len(whole), len(whole) // 39):
        (one / PLAN).write_bytes(whole[:length])
        out = tmp_path / f"{length}"
        plan = merge([one, two][:: 1 if length % 2 else -1], out, is_temporary=True).plan
        results = load_results(out)
        answers = {it.headline.answer.value for it in results.combinations}
        if "was put together from 3 cells" not in plan.note or results.plan.note != plan.note or answers != {"interim"}:
            silent.append((length, plan.note, answers))
    assert silent == []


def test_other_baselines_are_refused(run, refused):
    """Nothing says what the merged comparison would be with."""
    refused([run("one", [0]), run("two", [0], baseline="dense")], r"compares with baseline, '.*two' with dense")


def test_folder_that_is_no_experiment_is_refused(run, refused, tmp_path):
    """Before anything is written."""
    (tmp_path / "notes").mkdir()
    refused([run("one", [0]), tmp_path / "notes"], "notes' is no experiment")


def test_folder_with_other_things_is_not_merged_into(run, tmp_path):
    """It stays as it is."""
    (tmp_path / "notes").mkdir()
    (tmp_path / "notes" / "mine.txt").write_text("kept")
    with pytest.raises(UsageError, match="holds something else than an experiment"):
        merge([run("one", [0])], tmp_path / "notes")
    assert _files(tmp_path / "notes") == {"mine.txt": b"kept"}


@pytest.mark.skipif(os.name == "nt", reason="links take a privilege there")
def test_links_are_not_followed(run, refused):
    """A stranger's folder may lead anywhere."""
    one = run("one", [0])
    (_cells(one)[0] / "policy" / "mine").symlink_to("/etc/hostname")
    refused([one], "is a link; nothing is merged from a folder with links")


def test_number_of_seeds_that_no_cell_has_is_no_list(make_cell, make_plan, merged, tmp_path):
    """A stranger's plan may claim any number."""
    folders = [tmp_path / "one", tmp_path / "two"]
    for folder in folders:
        plan = make_plan(make_cell())
        create_store(folder, replace(plan, resolved={**plan.resolved, "seeds": 10**12}))
    _, store = merged(*folders)
    assert json.loads((store.folder / PLAN).read_text())["experiment"]["seeds"] == 10**12


@pytest.mark.parametrize(
    ("one", "other", "both"),
    [
        (
            Terms(averaged=5, grown=(2,)),
            Terms(averaged=5, joined=("arp",)),
            Terms(averaged=5, grown=(2,), joined=("arp",)),
        ),
        (Terms((2, 4), averaged=5), Terms(averaged=5), Terms()),
    ],
    ids=["added later", "looks beside all seeds at once"],
)
def test_what_both_agreed_on_stays_told(run, merged, one, other, both):
    """And what was added to either; other terms are those of no plan."""
    folders = [run("one", [0, 1]), run("two", [2, 3])]
    for folder, terms in zip(folders, (one, other), strict=True):
        replace(Store(folder).read_plan(), terms=terms).write(folder)
    assert merged(*folders)[1].read_plan().terms == both
